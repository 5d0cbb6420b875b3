"""Test vectors tests/web/rigs.json: pairs of cameras of every model, and how the solver rectifies them.

`python -m tests.helpers.rig_vectors` writes them for the tests of the SDK. The first pair is that of OpenCV's
samples, fitted to its corners.
"""

import json
from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np

from calibsolver import Camera, rig
from calibsolver.rig.rectification import rectify
from calibsolver.rig.start import RigidMotion
from tests.helpers.data import ROOT
from tests.helpers.solver.rigs import REAL_SIZE, real_pairs

RIGS_PATH = ROOT / "tests" / "web" / "rigs.json"
SIZE = (1280, 720)
# Some bend inwards, some outwards, some not at all; of the wide models one sees beyond 90 degrees.
LENSES: dict[str, list[tuple[float, list[float]]]] = {
    "rectilinear": [
        (1000.0, [-0.25, 0.06, 0.001, -0.0008, -0.004]),
        (700.0, [0.08, -0.02, -0.001, 0.0005, 0.001]),
        (1400.0, [0.0, 0.0, 0.0, 0.0, 0.0]),
    ],
    "fisheye": [
        (420.0, [-0.02, 0.003, -0.002, 0.0003]),
        (260.0, [0.05, -0.01, 0.001, 0.0]),
        (600.0, [0.0, 0.0, 0.0, 0.0]),
    ],
    "rational": [
        (800.0, [1.2, 0.3, 0.0005, -0.0004, 0.02, 1.5, 0.6, 0.06]),
        (900.0, [-0.3, 0.1, -0.001, 0.001, -0.01, 0.02, 0.01, 0.001]),
    ],
    "omnidirectional": [
        (900.0, [1.2, -0.1, 0.02, 0.0006, -0.0003]),
        (450.0, [0.6, 0.03, -0.005, -0.0004, 0.0005]),
    ],
}
# left camera -> right camera: side by side, one above the other, the right one on the left, far turned
POSES = (
    (0.01, -0.02, 0.005, -0.12, 0.002, 0.001),
    (-0.03, 0.02, 0.01, 0.004, -0.2, 0.01),
    (0.05, 0.1, -0.04, 0.4, -0.03, 0.02),
    (0.02, -0.6, 0.1, -2.0, 0.1, 0.7),
)
"""Poses rvec|tvec of the synthetic pairs."""


def pairs() -> list[dict[str, Any]]:
    """One record per pair: both cameras, the pose between them, and their rectification."""
    models = list(LENSES)
    cameras = {model: _camera(model, *LENSES[model][0]) for model in models}
    synthetic = [
        (cameras[one], cameras[other], POSES[index % len(POSES)])
        for index, (one, other) in enumerate(product(models, models))
    ]
    # beyond what a plane can show: of a wide lens the middle of the picture decides
    wide = _camera("fisheye", 180.0, [0.0, 0.0, 0.0, 0.0])
    return [pair_record(*pair) for pair in (_real(), *synthetic, (wide, cameras["rectilinear"], POSES[0]))]


def pair_record(left: Camera, right: Camera, pose: Sequence[float]) -> dict[str, Any]:
    """`pose`: rvec|tvec, left camera -> right camera."""
    rectification = rectify(left, right, RigidMotion.of_vector(np.asarray(pose)))
    return {
        "left": _record(left),
        "right": _record(right),
        "pose": {"rvec": list(pose[:3]), "tvec": list(pose[3:])},
        "R1": rectification.r1.tolist(),
        "R2": rectification.r2.tolist(),
        "P1": rectification.p1.tolist(),
        "P2": rectification.p2.tolist(),
        "Q": rectification.q.tolist(),
        "isVertical": rectification.is_vertical,
    }


def _camera(model: str, focal: float, coefficients: Sequence[float]) -> Camera:
    matrix = np.array([[focal, 0, 650.25], [0, 1.01 * focal, 352.5], [0, 0, 1.0]])
    return Camera(model=model, matrix=matrix, distortion=np.array(coefficients), img_size=SIZE)


def _record(camera: Camera) -> dict[str, Any]:
    return {
        "img_size": list(camera.img_size),
        "camera_matrix": camera.matrix.tolist(),
        "distortion_coefficients": camera.distortion.tolist(),
        "distortion_model": camera.model,
    }


def _real() -> tuple[Camera, Camera, list[float]]:
    calibration = rig.fit(real_pairs(), [(REAL_SIZE, "rectilinear")] * 2)
    return calibration.cameras[0], calibration.cameras[1], calibration.poses[1].tolist()


if __name__ == "__main__":
    RIGS_PATH.write_text(json.dumps(pairs()) + "\n")
