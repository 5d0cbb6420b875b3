"""`make bench DOCS=board-shape`: held-out errors of OpenCV, mrcal, the board as drawn, and in its shape.

The same folds and points: those that the fit of all views uses. OpenCV and mrcal are compared on plain lenses
only, mrcal with its own two numbers of warp where `MRCAL_PYTHON` (default /usr/bin/python3, where Debian
installs python3-mrcal) has it.
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
from tests.bench.capture import FISHEYE
from tests.bench.mrcal_files import MRCAL_PYTHON, in_mrcal
from tests.helpers.data import available, on_board

FOLDS = 5
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


def folds(count: int) -> list[tuple[list[int], list[int]]]:
    """Training and test views, by number, of each fold."""
    return [
        ([i for i in range(count) if i % FOLDS != fold], list(range(fold, count, FOLDS)))
        for fold in range(FOLDS)
    ]


def has_mrcal() -> bool:
    """True if mrcal is installed."""
    return not subprocess.run(
        [MRCAL_PYTHON, "-c", "import mrcal"], capture_output=True, check=False
    ).returncode


def mrcal(views: Sequence[View], size: tuple[int, int]) -> float:
    """Error of mrcal, px, with the warp that it estimates, begun at calibDB's optimum."""
    board, numbers, ours = on_board(views)
    parts = folds(len(views))
    with tempfile.TemporaryDirectory() as folder:
        paths = [Path(folder, f"{i}.cameramodel") for i in range(FOLDS)]
        for path, (training, _) in zip(paths, parts, strict=True):
            taken = tuple(ours[i] for i in training)
            source = ExportSource(fit(taken, size).camera, taken, board)
            path.write_bytes(formats.write(source, "mrcal", identity(size)).content)
        found = in_mrcal(WITH_WARP, paths)
    square = 0.0
    for (intrinsics, corners_3d), (_, test) in zip(found, parts, strict=True):
        camera = Camera.from_intrinsics("rectilinear", np.array(intrinsics), size)
        warped = np.array(corners_3d)
        seen = [View(warped[list(numbers[i])], views[i].image_points) for i in test]
        square += sum(map(len, seen)) * reprojection_score(camera, seen).rms ** 2
    return float(np.sqrt(square / sum(map(len, views))))


def held_out(views: Sequence[View], size: tuple[int, int], model: str) -> list[float]:
    """Errors of OpenCV (NaN of a fisheye lens), as drawn, and in the board's shape, px."""
    squares = np.zeros(3)
    for training_views, test_views in folds(len(views)):
        training, test = [views[i] for i in training_views], [views[i] for i in test_views]
        count = sum(map(len, test))
        if model == "rectilinear":
            _, theirs = opencv.calibrate(training, size, model)
            squares[0] += count * reprojection_score(theirs, test).rms ** 2
        for i, board_shape in enumerate((False, True), 1):
            found = fit(training, size, model, board_shape=board_shape)
            squares[i] += count * reprojection_score(found.camera, found.shaped(test)).rms ** 2
    errors = np.sqrt(squares / sum(map(len, views)))
    return [float("nan") if model != "rectilinear" else float(errors[0]), *errors[1:].tolist()]


def main() -> None:
    """Compare on every set that is at hand."""
    rows, to_drawn, to_opencv, to_mrcal = [], [], [], []
    with_mrcal = has_mrcal()
    for name in available(corners.NAMES):
        data, model = corners.load(name), "fisheye" if name in FISHEYE else "rectilinear"
        try:
            whole = fit(data.views, data.img_size, model)
            kept = [
                View(view.object_points[used], view.image_points[used])
                for view, used in zip(data.views, whole.used, strict=True)
                if used.sum() >= 6
            ]
            theirs, drawn, shaped = held_out(kept, data.img_size, model)
            warped = mrcal(kept, data.img_size) if with_mrcal and model == "rectilinear" else float("nan")
            shape = fit(kept, data.img_size, model).board_shape
        except CalibrationError as error:
            print(name, error)
            continue
        to_drawn.append(shaped / drawn)
        to_opencv += [shaped / theirs] if np.isfinite(theirs) else []
        to_mrcal += [shaped / warped] if np.isfinite(warped) else []
        rows.append(
            [
                name,
                str(len(kept)),
                f"{1000 * shape.sag:.2f} ± {1000 * shape.sag_std:.2f}" if shape else "as drawn",
                f"{1000 * shape.stretch:.2f} ± {1000 * shape.stretch_std:.2f}" if shape else "",
                *(f"{error:.4f}" if np.isfinite(error) else "" for error in (theirs, warped)),
                f"{drawn:.4f}",
                f"{shaped:.4f}",
                f"{shaped / drawn:.3f}",
            ]
        )
    header = ["set", "views", "sag, 1e-3", "stretch, 1e-3", "OpenCV, px", "mrcal", "as drawn"]
    header += ["in shape", "ratio"]
    conclusion = (
        f"In shape / as drawn: median {np.median(to_drawn):.3f}, largest {max(to_drawn):.3f}. In shape / "
        f"OpenCV: median {np.median(to_opencv):.3f}, largest {max(to_opencv):.3f}. "
    )
    if to_mrcal:
        conclusion += f"In shape / mrcal: median {np.median(to_mrcal):.3f}, largest {max(to_mrcal):.3f}."
    else:
        conclusion += "mrcal was not compared."
    document.replace("board shape", f"{document.table(header, rows)}\n\n{conclusion}")


if __name__ == "__main__":
    main()
