"""OpenCV's calibrations of one corner set, as a program of its own: it may hang, crash, or return nonsense.

`python -m tests.bench.opencv SET MODEL` prints one line of JSON for the whole set, then one for each fold:
what came out and how long it took. Whoever calls it stops it when it takes too long.
"""

import json
import sys
import time
from collections.abc import Sequence

import cv2
import numpy as np

from calibsolver import Camera, View
from calibsolver.fitting.resection import reprojection_score
from tests.bench import corners


def calibrate(views: Sequence[View], img_size: tuple[int, int], model: str) -> tuple[float, Camera]:
    """Rms px and camera by OpenCV's function of that model with its own defaults, skew fixed at 0."""
    objects = [v.object_points[:, None].astype(np.float32) for v in views]
    images = [v.image_points[:, None].astype(np.float32) for v in views]
    if model in ("rectilinear", "rational"):
        flags = cv2.CALIB_RATIONAL_MODEL if model == "rational" else 0
        rms, k, d, *_ = cv2.calibrateCamera(objects, images, img_size, None, None, flags=flags)
        d = d.ravel()[: 8 if model == "rational" else 5]
    elif model == "fisheye":
        flags = cv2.CALIB_RECOMPUTE_EXTRINSIC | cv2.CALIB_FIX_SKEW
        rms, k, d, *_ = cv2.fisheye.calibrate(
            *rows(views), img_size, np.eye(3), np.zeros((4, 1)), flags=flags
        )
    else:
        criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 200, 1e-8)
        rms, k, xi, d, *_ = cv2.omnidir.calibrate(
            *rows(views), img_size, None, None, None, flags=cv2.omnidir.CALIB_FIX_SKEW, criteria=criteria
        )
        d = np.concatenate([np.ravel(xi), np.ravel(d)])
    k = np.array([[k[0, 0], 0, k[0, 2]], [0, k[1, 1], k[1, 2]], [0, 0, 1]])
    return float(rms), Camera(model, k, np.ravel(d), img_size)


def rows(views: Sequence[View]) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Points as these two functions want them: (1, n, 3) and (1, n, 2), float64."""
    return [v.object_points[None].copy() for v in views], [v.image_points[None].copy() for v in views]


def attempt(training: Sequence[View], test: Sequence[View], img_size: tuple[int, int], model: str) -> None:
    begin = time.perf_counter()
    try:
        rms, camera = calibrate(training, img_size, model)
    except (cv2.error, ValueError) as error:
        print(json.dumps({"error": "throws", "detail": str(error)[:200]}), flush=True)
        return
    seconds = time.perf_counter() - begin
    if not test and seconds < 1:  # the first call also loads what the library loads once
        begin = time.perf_counter()
        calibrate(training, img_size, model)
        seconds = time.perf_counter() - begin
    if not (np.isfinite(rms) and np.isfinite(camera.intrinsics).all() and camera.intrinsics[0] > 1):
        print(json.dumps({"error": f"fx = {camera.intrinsics[0]:.3g}"}), flush=True)
        return
    left = reprojection_score(camera, test) if test else None
    print(
        json.dumps(
            {
                "rms": rms,
                "seconds": seconds,
                "fx": camera.intrinsics[0],
                "square": float(left.rms**2) if left and np.isfinite(left.rms) else None,
                "points": sum(len(view) for view in test),
            }
        ),
        flush=True,
    )


def main() -> None:
    cv2.setNumThreads(1)
    name, model = sys.argv[1:]
    data = corners.load(name)
    for training, test in data.parts():
        attempt(training, test, data.img_size, model)


if __name__ == "__main__":
    main()
