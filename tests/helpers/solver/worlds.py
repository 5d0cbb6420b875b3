"""Worlds of contributors and liars: specimens of one product, captured with any board, noise and care.

The ranges are those that real specimens show.
"""

from dataclasses import dataclass

import numpy as np

from calibsolver import Board, Camera
from calibsolver.consensus import Member
from tests.helpers.solver import populations, synthetic

SCATTER = 0.001, 0.004
"""Standard deviation of the focal length between specimens, as a share."""
NOISE = 0.05, 0.6  # px
CORNERS = 6, 2401  # of a board
VIEWS = 4, 15  # of a calibration
LIE = 0.001, 0.05
"""Share by which a lie changes the focal length."""
MAX_POINTS = 20_000
"""Points of one calibration, as the service admits them."""


@dataclass(frozen=True)
class World:
    """A product: its camera, and the standard deviation of its specimens."""

    camera: Camera
    scatter: float


def world(rng: np.random.Generator) -> World:
    cameras = synthetic.rectilinear_cameras(seed=int(rng.integers(1 << 30)))
    scatter = float(rng.uniform(*SCATTER))
    return World(cameras[int(rng.integers(len(cameras)))], scatter)


def specimen(product: World, rng: np.random.Generator) -> Camera:
    """Another specimen: its focal length, and its principal point by as many focal lengths, differ."""
    k = product.camera.intrinsics
    focal = float(k[0])
    k[:2] *= 1 + product.scatter * rng.normal()
    k[2:4] += product.scatter * focal * rng.normal(size=2)
    return Camera.from_intrinsics(product.camera.model, k, product.camera.img_size)


def lie(camera: Camera, kind: str, rng: np.random.Generator) -> Camera:
    """Camera of a liar: of another `focal` length, or of another `distortion` (and centre)."""
    k = camera.intrinsics
    if kind == "focal":
        k[:2] *= 1 + log_uniform(rng, *LIE) * rng.choice((-1, 1))
        return Camera.from_intrinsics(camera.model, k, camera.img_size)
    # Each coefficient by what moves the corner of the image by the same number of pixels, more or less.
    px = log_uniform(rng, 0.5, 40.0)
    radius = np.hypot(*camera.img_size) / 2 / k[0]
    reach = np.array([radius**3, radius**5, radius**2, radius**2, radius**7])
    while True:
        changed = k.copy()
        changed[2:4] += px * rng.normal(size=2) / 2
        changed[4:] += px / k[0] / reach * rng.normal(size=5) / 2
        found = Camera.from_intrinsics(camera.model, changed, camera.img_size)
        if synthetic.least_stretch(found) > 0.2:
            return found
        px *= 0.9


def member(name: str, camera: Camera, rng: np.random.Generator, corners: int | None = None) -> Member:
    """One calibration by a contributor with a board, a noise and a number of views of their own."""
    board = draw_board(rng, corners)
    count = int(rng.integers(VIEWS[0], VIEWS[1] + 1))
    count = max(min(count, MAX_POINTS // len(board.points)), VIEWS[0])
    seen = populations.views(camera, rng, log_uniform(rng, *NOISE), count, board=board)
    return Member(name, name, tuple(seen))


def draw_board(rng: np.random.Generator, corners: int | None = None) -> Board:
    """Board of so many corners, or of any number."""
    wanted = log_uniform(rng, *CORNERS) if corners is None else float(corners)
    rows = max(int(np.sqrt(wanted / rng.uniform(1.0, 1.7))), 2)
    columns = max(round(wanted / rows), 3)
    return Board(squares=(min(columns, 49) + 1, min(rows, 49) + 1), dictionary="DICT_APRILTAG_36h10")


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))
