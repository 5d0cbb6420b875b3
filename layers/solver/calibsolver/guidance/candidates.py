"""Poses of the board that a person can hold and a camera can see."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arrays import Array, IntArray, Mask
from ..board import Board
from ..fitting.normal_equations import Poses
from ..models import Model

DIMENSIONS = 6
MARGIN = 0.025
"""Of the image width, within which corners do not count: a hand misses by some."""
BEYOND = 15.0
"""Degrees."""


@dataclass(frozen=True)
class Range:
    """What is asked of a user at most.

    Attributes
    ----------
    width
        Smallest and largest apparent length of the board's longer side / the image's longer side.
    tilt
        Largest angle between the board's normal and the line of sight to its centre, degrees.
    roll
        Largest turn in the picture, degrees.
    inside
        Least share of the corners inside the image.
    oblique
        Largest angle between a ray and the board's normal, degrees: beyond it corners blur.
    spacing
        Least distance of neighbouring corners / image width.
    """

    width: tuple[float, float] = (0.30, 1.4)
    tilt: float = 58.0
    roll: float = 60.0
    inside: float = 0.6
    oblique: float = 66.0
    spacing: float = 16 / 1280


@dataclass(frozen=True, eq=False)
class Lattice:
    """Rows and columns of corners.

    Attributes
    ----------
    points
        (3, n) board frame, squares, row by row.
    rows, columns
        How many.
    step
        Largest distance of neighbours, squares, across and down.
    share
        How many corners of the board each stands for.
    """

    points: Array
    rows: int
    columns: int
    step: tuple[float, float]
    share: float

    @classmethod
    def of(cls, board: Board, most: int | None) -> "Lattice":
        """All corners of a board, or at most `most` evenly spread ones in a row and a column."""
        columns, rows = board.size[0] - 1, board.size[1] - 1
        x = np.arange(columns) if most is None else spread(columns, most)
        y = np.arange(rows) if most is None else spread(rows, most - 1)
        points = board.points.reshape(rows, columns, 3)[y][:, x].reshape(-1, 3)
        step = (float(np.diff(x).max()), float(np.diff(y).max()))
        return cls(np.ascontiguousarray(points.T), len(y), len(x), step, rows * columns / len(points))


def spread(count: int, most: int) -> IntArray:
    """At most `most` indices from 0 to `count` - 1, both ends among them."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(np.int64))


def sequence(count: int, offset: int) -> Array:
    """Evenly spread points (count, 6) of the unit cube: the additive recurrence of Roberts (2018), R6."""
    root = 2.0
    for _ in range(40):  # positive root of x^7 = x + 1
        root = (1 + root) ** (1 / (DIMENSIONS + 1))
    alpha = root ** -np.arange(1.0, DIMENSIONS + 1)
    points: Array = (0.5 + (np.arange(count)[:, None] + 1 + offset * count) * alpha) % 1.0
    return points


@dataclass(frozen=True, eq=False)
class Sight:
    """Rays over the image of one camera, looked up: the centre of a candidate need not be exact.

    Attributes
    ----------
    rays
        (rows, columns, 3) from corner to corner of the image.
    focal
        Focal length, px.
    """

    rays: Array
    focal: float
    img_size: tuple[int, int]

    @cached_property
    def reach(self) -> float:
        """Cosine of the largest angle from the axis at which a part of the board may be.

        A board may stick out of the picture, not lie beside the camera: that is BEYOND what the camera sees.
        """
        widest = np.degrees(np.arccos(np.nanmin(self.rays[:, :, 2])))
        return float(np.cos(np.radians(min(widest + BEYOND, 180))))

    @classmethod
    def of(
        cls, model: Model, k: Array, img_size: tuple[int, int], grid: tuple[int, int] = (17, 13)
    ) -> "Sight":
        """Return the sight of a camera with intrinsics k (p,)."""
        x, y = (np.linspace(-0.5, size - 0.5, n) for size, n in zip(img_size, grid, strict=True))
        rays = model.unproject(k, np.stack(np.meshgrid(x, y)))
        focal = float(k[0]) * model.magnification(k[4:])[0]
        return cls(np.ascontiguousarray(rays.transpose(1, 2, 0)), focal, img_size)

    def at(self, x: Array, y: Array) -> Array:
        """Return unit rays (c, 3) at places (c,) of [0, 1] across and down the image; NaN where none."""
        rows, columns, _ = self.rays.shape
        x, y = x * (columns - 1), y * (rows - 1)
        i, j = np.minimum(x.astype(int), columns - 2), np.minimum(y.astype(int), rows - 2)
        a, b = (x - i)[:, None], (y - j)[:, None]
        upper = self.rays[j, i] * (1 - a) + self.rays[j, i + 1] * a
        lower = self.rays[j + 1, i] * (1 - a) + self.rays[j + 1, i + 1] * a
        ray = upper * (1 - b) + lower * b
        unit: Array = ray / np.sqrt(np.einsum("ci,ci->c", ray, ray))[:, None]
        return unit


def poses(unit: Array, board: Board, sight: Sight, limits: Range) -> Poses:
    """Poses (c) of points (c, 6) of the unit cube: centre x, y, width, tilt, azimuth of the tilt, roll.

    A pose whose centre has no ray gets NaN translations.
    """
    ray = sight.at(middling(unit[:, 0]), middling(unit[:, 1]))
    tilt, width = shape(unit, limits)
    tilt, length = np.radians(tilt), width * max(sight.img_size)
    azimuth = 2 * np.pi * unit[:, 4]
    roll = np.radians(limits.roll) * (2 * middling(unit[:, 5]) - 1)
    if across(board, sight.img_size):
        roll = roll + np.pi / 2
    r = turned(ray) @ leaned(tilt, azimuth, roll)
    distance = sight.focal * max(board.size) / length
    center = board.outline.mean(axis=0)
    return Poses(r, ray * distance[:, None] - r @ center)


def turned(ray: Array) -> Array:
    """Rotations (c, 3, 3) by the shortest turns that take the optical axis to unit rays (c, 3)."""
    x, y, z = ray.T
    s = 1 / np.maximum(1 + z, 1e-9)  # Rodrigues' formula with sin = |(x, y)|, (1 - cos) / sin^2 = 1 / (1 + z)
    r = np.empty((len(ray), 3, 3))
    r[:, 0, 0], r[:, 0, 1], r[:, 0, 2] = 1 - x * x * s, -x * y * s, x
    r[:, 1, 0], r[:, 1, 1], r[:, 1, 2] = -x * y * s, 1 - y * y * s, y
    r[:, 2, 0], r[:, 2, 1], r[:, 2, 2] = -x, -y, z
    return r


def leaned(tilt: Array, azimuth: Array, roll: Array) -> Array:
    """Rotations (c, 3, 3): by a roll about z, then by a tilt about the axis at an azimuth in the picture."""
    ct, st, ca, sa = np.cos(tilt), np.sin(tilt), np.cos(azimuth), np.sin(azimuth)
    cr, sr = np.cos(roll), np.sin(roll)
    one = 1 - ct
    a, b, c = ct + ca * ca * one, ca * sa * one, ct + sa * sa * one
    r = np.empty((len(tilt), 3, 3))
    r[:, 0, 0], r[:, 0, 1], r[:, 0, 2] = a * cr + b * sr, b * cr - a * sr, sa * st
    r[:, 1, 0], r[:, 1, 1], r[:, 1, 2] = b * cr + c * sr, c * cr - b * sr, -ca * st
    r[:, 2, 0], r[:, 2, 1], r[:, 2, 2] = ca * st * sr - sa * st * cr, ca * st * cr + sa * st * sr, ct
    return r


def shape(unit: Array, limits: Range) -> tuple[Array, Array]:
    """Tilts (c,), degrees, and widths (c,), board / image, of points (c, 6) of the unit cube.

    Close, tilted and near the middle is what tells most: look there more often, and everywhere still.
    """
    low, high = limits.width
    return limits.tilt * np.sqrt(unit[:, 3]), low + (high - low) * np.sqrt(unit[:, 2])


def across(board: Board, img_size: tuple[int, int]) -> bool:
    """Whether the board must be turned by a quarter for its longer side to lie along the image's."""
    return (board.size[0] - board.size[1]) * (img_size[0] - img_size[1]) < 0


def middling(u: Array) -> Array:
    """Crowd points of [0, 1] towards its middle."""
    v = 2 * u - 1
    return 0.5 + 0.5 * v * np.sqrt(np.abs(v))


def visible(
    p: Array,
    q: Array,
    normal: Array,
    lattice: Lattice,
    model: Model,
    k: Array,
    img_size: tuple[int, int],
    limits: Range,
) -> tuple[Mask, Mask]:
    """Which corners (c, n) are seen, and which of the poses (c) may be asked for.

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
    margin = MARGIN * w
    x, y = q[:, 0], q[:, 1]
    seen = model.valid(k[4:], p.transpose(1, 0, 2))
    seen &= (x >= margin) & (y >= margin) & (x <= w - 1 - margin) & (y <= h - 1 - margin)
    grid = q.reshape(-1, 2, lattice.rows, lattice.columns)
    shown = seen.reshape(-1, lattice.rows, lattice.columns)
    # Of corners that are not seen it does not matter how close they lie: beyond the fold, anywhere.
    beside, below = shown[:, :, 1:] & shown[:, :, :-1], shown[:, 1:] & shown[:, :-1]
    across, down = np.diff(grid, axis=3), np.diff(grid, axis=2)
    nearest = np.minimum(
        np.sqrt(np.where(beside, (across**2).sum(axis=1), np.inf).min(axis=(1, 2))) / lattice.step[0],
        np.sqrt(np.where(below, (down**2).sum(axis=1), np.inf).min(axis=(1, 2))) / lattice.step[1],
    )
    facing = np.einsum("ci,cin->cn", normal, p) / np.sqrt(np.einsum("cin,cin->cn", p, p))
    good = seen.mean(axis=1) >= limits.inside
    good &= nearest >= limits.spacing * w
    good &= np.where(seen, facing, 1.0).min(axis=1) >= np.cos(np.radians(limits.oblique))
    return seen, good


def in_front(poses: Poses, board: Board, sight: Sight) -> Mask:
    """Whether all of the board, seen or not, is in front of the camera and shows it the printed side (c,)."""
    p = poses.r @ board.outline.T + poses.t[:, :, None]
    length = np.sqrt(np.einsum("cin,cin->cn", p, p))
    front = (p[:, 2] / length).min(axis=1) >= sight.reach
    front &= np.einsum("ci,cin->cn", poses.r[:, :, 2], p).min(axis=1) > 0
    return np.asarray(front, dtype=np.bool_)
