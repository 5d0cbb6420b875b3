"""OpenCV's calibrations of one corner set, as a program of its own: it may hang, crash, or return nonsense.

`python -m tests.bench.opencv SET MODEL` prints a line of JSON for the whole set, then one for each fold.
"""

import json
import sys
import time
from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np

from calibsolver import Camera, View
from calibsolver.fitting.resection import reprojection_score
from tests.bench import corners
from tests.helpers.data import float32


def calibrate(views: Sequence[View], img_size: tuple[int, int], model: str) -> tuple[float, Camera]:
    """Rms px and camera by OpenCV's function of that model with its own defaults, skew fixed at 0."""
    if model in ("rectilinear", "rational"):
        count, flags = (8, cv2.CALIB_RATIONAL_MODEL) if model == "rational" else (5, 0)
        rms, k, d, *_ = cv2.calibrateCamera(*float32(views), img_size, None, None, flags=flags)
        d = d.ravel()[:count]
    else:
        objects = [v.object_points[None].copy() for v in views]
        images = [v.image_points[None].copy() for v in views]
        if model == "fisheye":
            flags = cv2.CALIB_RECOMPUTE_EXTRINSIC | cv2.CALIB_FIX_SKEW
            start = np.eye(3), np.zeros((4, 1))
            rms, k, d, *_ = cv2.fisheye.calibrate(objects, images, img_size, *start, flags=flags)
        else:
            criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 200, 1e-8)
            start = None, None, None
            rms, k, xi, d, *_ = cv2.omnidir.calibrate(
                objects, images, img_size, *start, flags=cv2.omnidir.CALIB_FIX_SKEW, criteria=criteria
            )
            d = np.concatenate([np.ravel(xi), np.ravel(d)])
    k = np.array([[k[0, 0], 0, k[0, 2]], [0, k[1, 1], k[1, 2]], [0, 0, 1]])
    return float(rms), Camera(model, k, np.ravel(d), img_size)


def attempt(
    training: Sequence[View], test: Sequence[View], img_size: tuple[int, int], model: str
) -> dict[str, Any]:
    """Calibrate, and compare with the test views, if any."""
    begin = time.perf_counter()
    try:
        rms, camera = calibrate(training, img_size, model)
    except (cv2.error, ValueError):
        return {"error": "throws"}
    seconds = time.perf_counter() - begin
    if not test and seconds < 1:  # the first call also loads what the library loads once
        begin = time.perf_counter()
        calibrate(training, img_size, model)
        seconds = time.perf_counter() - begin
    if not (np.isfinite(rms) and np.isfinite(camera.intrinsics).all() and camera.intrinsics[0] > 1):
        return {"error": f"fx = {camera.intrinsics[0]:.3g}"}
    if not test:
        return {"rms": rms, "seconds": seconds}
    square = float(reprojection_score(camera, test).rms ** 2)
    return {"square": square if np.isfinite(square) else None, "points": sum(map(len, test))}


def main() -> None:
    cv2.setNumThreads(1)
    name, model = sys.argv[1:]
    data = corners.load(name)
    for training, test in ((data.training, ()), *data.folds()):
        print(json.dumps(attempt(training, test, data.img_size, model)), flush=True)


if __name__ == "__main__":
    main()
