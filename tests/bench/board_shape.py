"""`make bench DOCS=board-shape`: held-out errors of OpenCV, mrcal, the board as drawn, and in its shape.

The same folds and points: those that the fit of all views uses. OpenCV and mrcal are compared on plain lenses
only, mrcal with its own two numbers of warp if MRCAL_PYTHON has it.
"""

import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from calibsolver import CalibrationError, Camera, View, fit, formats
from calibsolver.fitting.resection import reprojection_score
from calibsolver.formats import ExportSource
from calibsolver.image_transform import identity
from tests.bench import corners, document, opencv
from tests.bench.corners import FISHEYE, FOLDS, Corners
from tests.bench.mrcal_files import MRCAL_PYTHON, in_mrcal
from tests.helpers.data import available, on_board

MIN_USED = 6
WITH_WARP = """
import json, sys
import mrcal, numpy as np
for path in sys.argv[1:]:
    inputs = mrcal.cameramodel(path).optimization_inputs()
    inputs["do_optimize_calobject_warp"] = True
    mrcal.optimize(**inputs)
    rows, columns = inputs["observations_board"].shape[1:3]
    board = mrcal.ref_calibration_object(columns, rows, 1.0, calobject_warp=inputs["calobject_warp"])
    print(json.dumps([inputs["intrinsics"][0].tolist(), board.reshape(-1, 3).tolist()]))
"""
"""Optimizes files of calibDB's, board warp included: intrinsics, and the corners of the warped board."""


def has_mrcal() -> bool:
    command = [MRCAL_PYTHON, "-c", "import mrcal"]
    return not subprocess.run(command, capture_output=True, check=False).returncode


def mrcal(data: Corners) -> float:
    """Error of mrcal, px, with the warp that it estimates, begun at calibDB's optimum."""
    board, numbers, ours = on_board(data.views)
    with tempfile.TemporaryDirectory() as folder:
        paths = [Path(folder, f"{fold}.cameramodel") for fold in range(FOLDS)]
        for fold, path in enumerate(paths):
            taken = tuple(view for view, part in zip(ours, data.split, strict=True) if part != fold)
            source = ExportSource(fit(taken, data.img_size).camera, taken, board)
            path.write_bytes(formats.write(source, "mrcal", identity(data.img_size)).content)
        found = in_mrcal(WITH_WARP, paths)
    squares, points = [], []
    for fold, (intrinsics, corners_3d) in enumerate(found):
        camera = Camera.from_intrinsics("rectilinear", np.array(intrinsics), data.img_size)
        warped = np.array(corners_3d)
        seen = [
            View(warped[list(ids)], view.image_points)
            for ids, view, part in zip(numbers, data.views, data.split, strict=True)
            if part == fold
        ]
        squares.append(reprojection_score(camera, seen).rms ** 2)
        points.append(sum(map(len, seen)))
    return corners.rms(squares, points)


def held_out(data: Corners, model: str) -> tuple[float, float]:
    """Errors as drawn, and in the board's shape, px."""
    squares, points = [], []
    for training, test in data.folds():
        fits = [fit(training, data.img_size, model, board_shape=shape) for shape in (False, True)]
        squares.append([reprojection_score(f.camera, f.shaped(test)).rms ** 2 for f in fits])
        points.append(sum(map(len, test)))
    drawn, shaped = (corners.rms(column, points) for column in zip(*squares, strict=True))
    return drawn, shaped


def held_out_of_opencv(data: Corners) -> float:
    return corners.rms(*data.held_out(lambda views: opencv.calibrate(views, data.img_size, "rectilinear")[1]))


def used_views(data: Corners, model: str) -> Corners:
    """Points that the fit of all views uses."""
    pairs = zip(data.views, fit(data.views, data.img_size, model).used, strict=True)
    views = [View(v.object_points[used], v.image_points[used]) for v, used in pairs if used.sum() >= MIN_USED]
    return Corners.of(data.name, data.img_size, views)


def ratios(values: Sequence[float]) -> str:
    finite = [value for value in values if np.isfinite(value)]
    return f"median {np.median(finite):.3f}, largest {max(finite):.3f}"


def main() -> None:
    rows, errors = [], []
    with_mrcal = has_mrcal()
    for name in available(corners.NAMES):
        model = "fisheye" if name in FISHEYE else "rectilinear"
        theirs = warped = np.nan
        try:
            data = used_views(corners.load(name), model)
            if model == "rectilinear":
                theirs = held_out_of_opencv(data)
                warped = mrcal(data) if with_mrcal else np.nan
            drawn, shaped = held_out(data, model)
            shape = fit(data.views, data.img_size, model).board_shape
        except CalibrationError as error:
            print(name, error)
            continue
        errors.append((theirs, warped, drawn, shaped))
        rows.append(
            [
                name,
                str(len(data.views)),
                f"{1000 * shape.sag:.2f} ± {1000 * shape.sag_std:.2f}" if shape else "as drawn",
                f"{1000 * shape.stretch:.2f} ± {1000 * shape.stretch_std:.2f}" if shape else "",
                *(f"{error:.4f}" if np.isfinite(error) else "" for error in errors[-1]),
                f"{shaped / drawn:.3f}",
            ]
        )
    header = ["set", "views", "sag, 1e-3", "stretch, 1e-3", "OpenCV, px", "mrcal", "as drawn"]
    header += ["in shape", "ratio"]
    to_opencv, to_mrcal, to_drawn = (np.array(errors)[:, 3:] / np.array(errors)[:, :3]).T
    conclusion = f"In shape / as drawn: {ratios(to_drawn)}. In shape / OpenCV: {ratios(to_opencv)}. "
    conclusion += f"In shape / mrcal: {ratios(to_mrcal)}." if with_mrcal else "mrcal was not compared."
    document.replace("board shape", f"{document.table(header, rows)}\n\n{conclusion}")


if __name__ == "__main__":
    main()
