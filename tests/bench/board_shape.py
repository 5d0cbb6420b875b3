"""`make bench DOCS=board-shape`: held-out errors of OpenCV, of the board as drawn, and in its shape.

The same folds and points: those that the fit of all views uses. OpenCV is compared on plain lenses only.
"""

from collections.abc import Callable, Sequence

import cv2
import numpy as np

from calibsolver import CalibrationError, Camera, View, fit
from calibsolver.fitting.resection import reprojection_score
from tests.bench import corners, document
from tests.bench.capture import FISHEYE
from tests.helpers.data import available

Fit = Callable[[Sequence[View]], tuple[Camera, Sequence[View]]]
FOLDS = 5


def opencv(training: Sequence[View], size: tuple[int, int]) -> Camera:
    """Camera of `cv2.calibrateCamera`."""
    points = [[v.object_points.astype(np.float32), v.image_points.astype(np.float32)] for v in training]
    _, matrix, distortion, _, _ = cv2.calibrateCamera(*zip(*points, strict=True), size, None, None)
    return Camera("rectilinear", matrix, distortion.ravel()[:5], size)


def held_out(views: Sequence[View], size: tuple[int, int], model: str) -> list[float]:
    """Errors of OpenCV (NaN of a fisheye lens), as drawn, and in the board's shape, px."""
    squares = np.zeros(3)
    for fold in range(FOLDS):
        training, test = [v for i, v in enumerate(views) if i % FOLDS != fold], views[fold::FOLDS]
        count = sum(map(len, test))
        if model == "rectilinear":
            squares[0] += count * reprojection_score(opencv(training, size), test).rms ** 2
        for i, board_shape in enumerate((False, True), 1):
            found = fit(training, size, model, board_shape=board_shape)
            squares[i] += count * reprojection_score(found.camera, found.shaped(test)).rms ** 2
    errors = np.sqrt(squares / sum(map(len, views)))
    return [float("nan") if model != "rectilinear" else float(errors[0]), *errors[1:].tolist()]


def main() -> int:
    """Compare on every set that is at hand."""
    rows, to_drawn, to_opencv = [], [], []
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
            shape = fit(kept, data.img_size, model, board_shape=True).board_shape
        except CalibrationError as error:
            print(name, error)
            continue
        to_drawn.append(shaped / drawn)
        to_opencv += [shaped / theirs] if np.isfinite(theirs) else []
        rows.append(
            [
                name,
                str(len(kept)),
                f"{1000 * shape.sag:.2f} ± {1000 * shape.sag_std:.2f}" if shape else "as drawn",
                f"{1000 * shape.stretch:.2f} ± {1000 * shape.stretch_std:.2f}" if shape else "",
                f"{theirs:.4f}" if np.isfinite(theirs) else "",
                f"{drawn:.4f}",
                f"{shaped:.4f}",
                f"{shaped / drawn:.3f}",
            ]
        )
        print(*rows[-1], flush=True)
    header = ["set", "views", "sag, 1e-3", "stretch, 1e-3", "OpenCV, px", "as drawn", "in shape", "ratio"]
    conclusion = (
        f"In shape / as drawn: median {np.median(to_drawn):.3f}, largest {max(to_drawn):.3f}. In shape / "
        f"OpenCV: median {np.median(to_opencv):.3f}, largest {max(to_opencv):.3f}. mrcal was not compared."
    )
    document.replace("board shape", f"{document.table(header, rows)}\n\n{conclusion}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
