"""Poses of the board that a person can hold and a camera can see."""

from dataclasses import dataclass

import numpy as np

from . import rotation
from .arrays import Array, Mask
from .board import Board
from .models import Model
from .normal import Poses

DIMENSIONS = 6


@dataclass(frozen=True)
class Range:
    """What is asked of a user at most.

    Attributes
    ----------
    width
        Smallest and largest apparent width of the board / image width.
    tilt
        Largest angle between the board's normal and the line of sight to its centre, degrees.
    roll
        Largest turn in the picture, degrees.
    inside
        Least share of the corners inside the image.
    """

    width: tuple[float, float] = (0.30, 1.15)
    tilt: float = 55.0
    roll: float = 60.0
    inside: float = 0.6


OBLIQUE = np.cos(np.radians(62))
"""Cosine of the most oblique angle between a ray and the board's normal: beyond it corners blur."""
SPACING = 16 / 1280
"""Least distance of neighbouring corners / image width."""


def sequence(count: int, offset: int) -> Array:
    """Evenly spread points (count, 6) of the unit cube: the additive recurrence of Roberts (2018), R6."""
    root = 2.0
    for _ in range(40):  # positive root of x^7 = x + 1
        root = (1 + root) ** (1 / (DIMENSIONS + 1))
    alpha = root ** -np.arange(1.0, DIMENSIONS + 1)
    points: Array = (0.5 + (np.arange(count)[:, None] + 1 + offset * count) * alpha) % 1.0
    return points


def poses(
    unit: Array, board: Board, model: Model, k: Array, img_size: tuple[int, int], limits: Range
) -> Poses:
    """Poses (c) of points (c, 6) of the unit cube: centre x, y, width, tilt, azimuth of the tilt, roll.

    A pose whose centre has no ray gets NaN translations.
    """
    w, h = img_size
    low, high = limits.width
    q = np.stack([unit[:, 0] * w - 0.5, unit[:, 1] * h - 0.5])
    width = (low * (high / low) ** unit[:, 2]) * w
    tilt = np.radians(limits.tilt) * np.sqrt(unit[:, 3])  # more of the steep ones: they tell more
    azimuth = 2 * np.pi * unit[:, 4]
    roll = np.radians(limits.roll) * (2 * unit[:, 5] - 1)
    ray = model.unproject(k, q).T
    r = turn_to(ray) @ about(np.stack([np.cos(azimuth), np.sin(azimuth), 0 * azimuth], axis=1), tilt)
    r = r @ about(np.broadcast_to([0.0, 0.0, 1.0], (len(unit), 3)), roll)
    distance = k[0] * board.size[0] / width
    center = board.outline.mean(axis=0)
    t = ray * distance[:, None] - r @ center
    return Poses(r, t)


def about(axis: Array, angle: Array) -> Array:
    """Rotations (c, 3, 3) about unit axes (c, 3) by angles (c,), radians."""
    return rotation.matrix(axis * angle[:, None])


def turn_to(ray: Array) -> Array:
    """Shortest rotations (c, 3, 3) that take the optical axis to unit rays (c, 3)."""
    axis = np.stack([-ray[:, 1], ray[:, 0], np.zeros(len(ray))], axis=1)
    s = np.hypot(ray[:, 0], ray[:, 1])
    angle = np.arctan2(s, ray[:, 2])
    return about(axis / np.maximum(s, 1e-12)[:, None], angle)


def visible(
    p: Array,
    q: Array,
    normal: Array,
    board: Board,
    model: Model,
    k: Array,
    img_size: tuple[int, int],
    limits: Range,
) -> tuple[Mask, Mask]:
    """Which corners (c, n) are seen, and which of the poses (c) can be asked for.

    Parameters
    ----------
    p
        (c, 3, n) corners in the camera frame, squares.
    q
        (c, 2, n) px.
    normal
        (c, 3) normals of the boards, away from the viewer, camera frame.
    """
    w, h = img_size
    margin = 0.01 * w
    x, y = q[:, 0], q[:, 1]
    with np.errstate(invalid="ignore"):
        seen = model.valid(k[4:], p.transpose(1, 0, 2))
        seen &= (x >= margin) & (y >= margin) & (x <= w - 1 - margin) & (y <= h - 1 - margin)
        columns, rows = board.size[0] - 1, board.size[1] - 1
        grid = q.reshape(-1, 2, rows, columns)
        nearest = np.minimum(
            np.hypot(*np.moveaxis(np.diff(grid, axis=3), 1, 0)).min(axis=(1, 2)),
            np.hypot(*np.moveaxis(np.diff(grid, axis=2), 1, 0)).min(axis=(1, 2)),
        )
        length = np.sqrt(np.sum(p * p, axis=1))
        facing = np.einsum("ci,cin->cn", normal, p) / length
        good = seen.mean(axis=1) >= limits.inside
        good &= nearest >= SPACING * w
        good &= np.where(seen, facing, 1.0).min(axis=1) >= OBLIQUE
        # Nothing of the board, seen or not, may be behind the user's camera.
        good &= facing.min(axis=1) > 0
    return seen, good
