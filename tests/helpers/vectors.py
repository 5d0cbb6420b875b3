"""Test vectors `tests/data/vectors.json` of the solver, lookups and the SDK: lenses, and pairs of cameras.

`python -m tests.helpers.vectors` writes them by the solver. A lens is one of 401 cameras: its model, `k` (fx
fy cx cy and the distortion), rays with their pixels (null outside the valid domain), pixels that a ray of the
domain meets (`seen`), and pixels that none does (`missed`). A pair is two cameras of any models, the pose
between them, and their rectification; the first is that of OpenCV's samples.
"""

import json
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibsolver import Camera, models
from calibsolver.rig.rectification import rectify
from calibsolver.rig.start import RigidMotion
from tests.helpers.data import ROOT
from tests.helpers.solver.export_sources import IMG_SIZE, truth

VECTORS_PATH = ROOT / "tests" / "data" / "vectors.json"
CAMERAS_PER_MODEL = 100
# Of the largest angle of the valid domain: on the axis, to just within the edge, and beyond it.
SHARES = (0.0, 0.3, 0.7, 0.999, 1 - 1e-6, 1 + 1e-6, 1.05)
MAX_PIXEL = 5e3  # px: rays that meet the plane farther out are left out; doubles end at 1e-9 px soon after
EXAMPLE = (
    "rectilinear",
    [900.0, 900.0, 640.0, 360.0, -0.273, -0.099, 0.003, 0.0, -0.239],
    [0.778, 0.261, 1.07],
)
REAL = (
    [532.4822, 532.2687, 342.298, 234.1424, -0.310475, 0.175, 0.001029, 8.6e-05, -0.062531],
    [535.1579, 534.5892, 326.3412, 249.3965, -0.294783, 0.097179, -0.000484, -0.000682, 0.013236],
)
"""Intrinsics of OpenCV's pair, fitted to its corners and rounded."""
REAL_POSE = (0.007301, 0.004979, -0.003426, -3.316336, 0.036781, -0.006964)
# left camera -> right camera: side by side, one above the other, the right one on the left, far turned
POSES = (
    (0.01, -0.02, 0.005, -0.12, 0.002, 0.001),
    (-0.03, 0.02, 0.01, 0.004, -0.2, 0.01),
    (0.05, 0.1, -0.04, 0.4, -0.03, 0.02),
    (0.02, -0.6, 0.1, -2.0, 0.1, 0.7),
)
"""Poses rvec|tvec of the synthetic pairs."""


def recorded(name: str) -> list[dict[str, Any]]:
    """Return the `lenses` or `pairs` of the file."""
    records: list[dict[str, Any]] = json.loads(VECTORS_PATH.read_text())[name]
    return records


def lenses() -> list[dict[str, Any]]:
    rng = np.random.default_rng(30)
    model, k, ray = EXAMPLE
    records = [_lens(model, k, np.array([ray, [0.4, -0.2, 1.0], [0.0, 0.0, 0.0]]), rng)]
    for name in models.NAMES:
        for number in range(CAMERAS_PER_MODEL):
            focal = round(float(rng.uniform(200, 1800)), 2)
            center = (np.array([639.5, 359.5]) + rng.normal(size=2) * 25).round(2)
            k = [focal, round(focal * 1.01, 2), *center.tolist(), *_distortion(name, number, rng)]
            records.append(_lens(name, k, _rays(_camera(name, k), rng), rng))
    return records


def _distortion(name: str, number: int, rng: np.random.Generator) -> list[float]:
    """Coefficients from none (every tenth) to far stronger than those of lenses."""
    scale = 0.0 if number % 10 == 0 else float(rng.choice([0.1, 0.4, 1.0, 2.0]))
    tangential = float(rng.choice([0.0, 0.001, 0.01, 0.1]))
    by_order = {"1": 0.5, "4": 0.7}
    sigmas = [
        tangential if coefficient[0] == "p" else by_order.get(coefficient[-1], 0.3)
        for coefficient in models.get(name).coefficients
    ]
    d = scale * rng.normal(size=len(sigmas)) * sigmas
    if name == "omnidirectional":
        d[0] = rng.choice([-0.4, 0.0, 0.7, 1.0, 1.2, 2.5]) + 0.1 * scale * rng.normal()
    return [float(c) for c in d.round(5)]


def _rays(camera: Camera, rng: np.random.Generator) -> NDArray[np.float64]:
    """Rays at shares of the domain's angle and anywhere else, of any length."""
    theta = np.concatenate([np.array(SHARES) * camera.domain().angle, rng.uniform(0, np.pi, 2)])
    phi = rng.uniform(0, 2 * np.pi, len(theta))
    v = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)
    rays: NDArray[np.float64] = (v * rng.uniform(0.5, 5, (len(theta), 1))).round(9)
    return rays[~(np.abs(camera.project(rays)) > MAX_PIXEL).any(axis=1)]


def _lens(name: str, k: list[float], rays: NDArray[np.float64], rng: np.random.Generator) -> dict[str, Any]:
    camera = _camera(name, k)
    pixels = camera.project(rays)
    anywhere = rng.uniform(-1, 2, (5, 2)) * IMG_SIZE
    drawn = np.concatenate([pixels[np.isfinite(pixels[:, 0])][:4], anywhere]).round(2)
    is_seen = np.isfinite(camera.unproject(drawn)[:, 0])
    return {
        "model": name,
        "k": k,
        "rays": rays.tolist(),
        "pixels": [q if np.isfinite(q).all() else None for q in pixels.round(10).tolist()],
        "seen": drawn[is_seen].tolist(),
        "missed": drawn[~is_seen].tolist(),
    }


def _camera(name: str, k: list[float], img_size: tuple[int, int] = IMG_SIZE) -> Camera:
    return Camera.from_intrinsics(name, np.array(k), img_size)


def pairs() -> list[dict[str, Any]]:
    left, right = (_camera("rectilinear", k, (640, 480)) for k in REAL)
    cameras = [(truth(one), truth(other)) for one, other in product(models.NAMES, models.NAMES)]
    synthetic = [_pair(*both, POSES[index % len(POSES)]) for index, both in enumerate(cameras)]
    # beyond what a plane can show: of a wide lens the middle of the picture decides
    wide = _camera("fisheye", [180.0, 181.8, 650.25, 352.5, 0.0, 0.0, 0.0, 0.0])
    return [_pair(left, right, REAL_POSE), *synthetic, _pair(wide, truth("rectilinear"), POSES[0])]


def _pair(left: Camera, right: Camera, pose: tuple[float, ...]) -> dict[str, Any]:
    """`pose`: rvec|tvec, left camera -> right camera."""
    rectification = rectify(left, right, RigidMotion.of_vector(np.asarray(pose)))
    return {
        "left": left.record(),
        "right": right.record(),
        "pose": {"rvec": list(pose[:3]), "tvec": list(pose[3:])},
        "R1": rectification.r1.tolist(),
        "R2": rectification.r2.tolist(),
        "P1": rectification.p1.tolist(),
        "P2": rectification.p2.tolist(),
        "Q": rectification.q.tolist(),
        "isVertical": rectification.is_vertical,
    }


if __name__ == "__main__":
    parts = []
    for name, records in (("lenses", lenses()), ("pairs", pairs())):
        lines = ",\n".join(json.dumps(record, separators=(",", ":")) for record in records)
        parts.append(f'"{name}":[\n{lines}\n]')
    VECTORS_PATH.write_text(f"{{{','.join(parts)}}}\n")
