"""ARToolKit itself, which is what AR.js tracks with, reads our camera_para.dat as we mean it."""

import numpy as np

from calibsolver import formats
from tests.helpers.node import run_module
from tests.helpers.solver.export_sources import IMG_SIZE, subject

W, H = IMG_SIZE
PROGRAM = """
import artoolkit from "@ar-js-org/artoolkit5-js";
import { readFileSync } from "node:fs";
console.log = () => {};
const { file, width, height } = JSON.parse(readFileSync(0, "utf8"));
const control = await artoolkit.ARController.initWithDimensions(width, height, Uint8Array.from(file));
process.stdout.write(`\\n${JSON.stringify([...control.getCameraMatrix()])}`);
process.exit(0); // it keeps a timer
"""


def test_artoolkit_draws_as_the_camera_that_was_written() -> None:
    """But for its own matrix, which takes the picture to be a pixel smaller than it is."""
    written = formats.write(subject("rectilinear"), "artoolkit")
    matrix = run_module(PROGRAM, sent={"file": list(written.content), "width": W, "height": H})
    ours = np.frombuffer(written.content, ">f8", 12, offset=8).reshape(3, 4)[:, :3]
    rng = np.random.default_rng(2)
    rays = np.column_stack([rng.uniform(-0.6, 0.6, 200), rng.uniform(-0.35, 0.35, 200), np.ones(200)])
    pinhole = (rays @ ours.T)[:, :2] + 0.5  # px from the picture's corner
    drawn = np.column_stack([rays * (1, -1, -1), np.ones(200)]) @ np.array(matrix).reshape(4, 4)
    ndc = drawn[:, :2] / drawn[:, 3:]
    off = np.linalg.norm((ndc * (1, -1) + 1) / 2 * IMG_SIZE - pinhole, axis=1)
    assert off.max() < 1
    assert off.max() > 0.2, "or `applyCalibration` would not be needed beside it"
