"""`make bench DOCS=honesty`: error bars against real cameras.

Views of a real corner set are split at random: into two halves, or six (four) views and the rest. Both parts
are fitted, and the difference of the two cameras is compared with what the two covariances predict together.
`cv2.calibrateCameraExtended` gives intervals of single parameters.

`TIMES=5` takes five times as many splits, the same ones first, and writes nothing.
"""

import os
from collections.abc import Iterator, Sequence

import cv2
import numpy as np

from calibsolver import Calibration, View, models
from calibsolver.arrays import Array, symmetric_inverse
from calibsolver.fitting.uncertainty import projection_jacobian_rotation_free, variance
from tests.bench import corners, document
from tests.bench.corners import try_fit
from tests.helpers.data import available, float32
from tests.helpers.solver import synthetic

GRID = (20, 15)
TIMES = int(os.environ.get("TIMES", "1"))
SPLITS = 6 * TIMES
DRAWS = 8 * TIMES
TRUE_DRAWS = 100
MIN_VIEWS = 12
MAX_HELD_OUT_RATIO = 1.5
"""Rms of a model's fit / that of the better model of a set, up to which the model is believable."""
COVARIANCES = {"calibDB": "ours", "calibDB, if true": "true", "white noise": "white"}
DEVIATIONS = {"calibDB": "z", "`cv2.calibrateCameraExtended`": "opencv"}
INTERVALS = """The same for single parameters (fx, fy, cx, cy of `rectilinear`), difference / deviation. If
deviations are true the median is 0.67, the 90th percentile 1.64, and 5 % lie above 2:"""


def splits(count: int, size: int | None, rng: np.random.Generator) -> Iterator[tuple[list[int], list[int]]]:
    """Random splits of so many views: `size` and the rest, or halves."""
    for _ in range(SPLITS if size is None else DRAWS):
        order = rng.permutation(count).tolist()
        first = size or count // 2
        yield order[:first], order[first:]


def white(calibration: Calibration) -> Array:
    """Covariance that white noise of the corners would give."""
    return symmetric_inverse(np.asarray(calibration.information))


def jacobian(calibration: Calibration) -> Array:
    camera = calibration.camera
    return projection_jacobian_rotation_free(
        models.get(camera.model), camera.intrinsics, camera.img_size, GRID
    )


def predicted(calibration: Calibration, covariance: Array) -> float:
    """Mean square projection error over the image, px^2."""
    return float(np.nanmean(variance(jacobian(calibration), covariance)))


def ratios(one: Calibration, other: Calibration) -> tuple[float, float]:
    """Difference / predicted, by the covariance and by that of white noise."""
    error = synthetic.projection_error(one.camera, other.camera, GRID)
    error = error[error < one.camera.img_size[0]]
    square = float(np.mean(error**2)) if error.size else float("inf")
    robust = predicted(one, np.asarray(one.covariance)) + predicted(other, np.asarray(other.covariance))
    plain = predicted(one, white(one)) + predicted(other, white(other))
    return float(np.sqrt(square / robust)), float(np.sqrt(square / plain))


def ratios_if_true(one: Calibration, other: Calibration, rng: np.random.Generator) -> Array:
    """Ratios (TRUE_DRAWS,) of differences that are drawn from what the two covariances predict.

    Few directions make up most of the error, so that they scatter nearly as widely as those of one number,
    with a median of 0.67 and a 90th percentile of 1.64.
    """
    factors = []
    for each in (one, other):
        values, axes = np.linalg.eigh(each.covariance)
        deviations = axes * np.sqrt(np.maximum(values, 0))
        factors.append((jacobian(each) @ deviations).reshape(-1, len(values)))
    factor = np.concatenate(factors, axis=1)
    factor = factor[np.isfinite(factor).all(axis=1)]
    shares = np.maximum(np.linalg.eigvalsh(factor.T @ factor), 0)
    square: Array = rng.standard_normal((TRUE_DRAWS, len(shares))) ** 2 @ (shares / shares.sum())
    return np.sqrt(square)


def opencv_parameters(views: Sequence[View], img_size: tuple[int, int]) -> tuple[Array, Array]:
    """fx, fy, cx, cy (4,) and their deviations (4,) as `cv2.calibrateCameraExtended` gives them."""
    _, k, _, _, _, std, *_ = cv2.calibrateCameraExtended(*float32(views), img_size, None, None)
    return np.array([k[0, 0], k[1, 1], k[0, 2], k[1, 2]]), np.ravel(std)[:4]


def parameters(calibration: Calibration) -> tuple[Array, Array]:
    """fx, fy, cx, cy (4,) and their deviations (4,)."""
    return calibration.camera.intrinsics[:4], np.sqrt(np.diagonal(calibration.covariance))[:4]


def standardized(one: tuple[Array, Array], other: tuple[Array, Array]) -> list[float]:
    z: Array = np.abs(one[0] - other[0]) / np.sqrt(one[1] ** 2 + other[1] ** 2)
    return z.tolist()


def measure(size: int | None) -> tuple[dict[str, list[float]], int]:
    """Ratios of all believable sets and models; and how many set x model there are."""
    found: dict[str, list[float]] = {"ours": [], "true": [], "white": [], "z": [], "opencv": []}
    pairs, draws = 0, np.random.default_rng(2)
    for name in available(corners.NAMES):
        data = corners.load(name)
        if len(data.views) < MIN_VIEWS:
            continue
        fits = {model: try_fit(data.views, data.img_size, model) for model in ("rectilinear", "fisheye")}
        errors = {model: each.avg_reprojection_error for model, each in fits.items() if each}
        for model, error in errors.items():
            if error > MAX_HELD_OUT_RATIO * min(errors.values()):
                continue
            pairs += 1
            for halves in splits(len(data.views), size, np.random.default_rng(1)):
                parts = [[data.views[i] for i in half] for half in halves]
                one, other = (try_fit(part, data.img_size, model) for part in parts)
                if one is None or other is None:
                    continue
                robust, plain = ratios(one, other)
                found["ours"].append(robust)
                found["white"].append(plain)
                found["true"] += ratios_if_true(one, other, draws).tolist()
                if model == "rectilinear":
                    found["z"] += standardized(parameters(one), parameters(other))
                    theirs = [opencv_parameters(part, data.img_size) for part in parts]
                    found["opencv"] += standardized(*theirs)
    return found, pairs


def main() -> None:
    rows, intervals = [], []
    for title, size in (
        ("two halves", None),
        ("six views, and the rest", 6),
        ("four views, and the rest", 4),
    ):
        found, pairs = measure(size)
        for what, key in COVARIANCES.items():
            rows.append([title, what, str(pairs), str(len(found["ours"])), *summary(found[key])])
        for what, key in DEVIATIONS.items():
            intervals.append([title, what, str(len(found[key])), *summary(found[key])])
        print(title, *rows[-3:], *intervals[-2:], sep="\n", flush=True)
    if TIMES != 1:
        return
    figures = ["median", "90th percentile", "above 2"]
    parts = (
        document.table(["parts", "covariance", "set x model", "splits", *figures], rows),
        INTERVALS,
        document.table(["parts", "deviations", "differences", *figures], intervals),
    )
    document.replace("honesty", "\n\n".join(parts))


def summary(values: Sequence[float]) -> list[str]:
    above = np.mean(np.array(values) > 2)
    return [f"{np.median(values):.2f}", f"{np.quantile(values, 0.9):.2f}", f"{above:.0%}"]


if __name__ == "__main__":
    main()
