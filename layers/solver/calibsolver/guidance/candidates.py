"""Candidate poses of the board that a person can hold and a camera can see."""

from dataclasses import dataclass

import numpy as np

from .. import models, rotation
from ..arrays import Array, Mask, subsample
from ..board import Board
from ..camera import Camera
from ..fitting.normal_equations import Poses

MAX_OUTSIDE_VIEW_DEG = 15.0
"""Angle by which a part of the board may lie outside the field of view."""


@dataclass(frozen=True)
class PoseLimits:
    """Limits of the poses that a user is asked for.

    Attributes
    ----------
    width
        Smallest and largest apparent length of the board's longer side / the image's.
    max_tilt_deg
        Angle between the board's normal and the line of sight to its centre.
    min_visible
        Share of the corners that a detector is expected to find.
    max_incidence_deg
        Angle between a ray and the board's normal, beyond which corners blur.
    min_spacing
        Distance of neighbouring corners / image width.
    border
        Distance / image width by which a hand misses a pose, at most.
    """

    width: tuple[float, float] = (0.30, 1.4)
    max_tilt_deg: float = 58.0
    max_roll_deg: float = 60.0
    min_visible: float = 0.6
    max_incidence_deg: float = 66.0
    min_spacing: float = 16 / 1280
    border: float = 0.025


@dataclass(frozen=True, eq=False)
class CornerGrid:
    """Rows and columns of a board's corners, all or a subset of them.

    Attributes
    ----------
    points
        (3, n) board frame, squares, row by row.
    step
        Largest distance of neighbours, squares, across and down.
    multiplicity
        Corners of the board that each of these stands for.
    support
        (g, m, 2, n) what a camera must see to find each (`Board.support`), relative to it.
    """

    points: Array
    rows: int
    columns: int
    step: tuple[float, float]
    multiplicity: float
    support: Array

    @classmethod
    def of(cls, board: Board, max_columns: int | None) -> "CornerGrid":
        """All corners of a board, or evenly spaced ones in at most `max_columns`, and one row less."""
        rows, columns = board.lattice.shape
        x, y = np.arange(columns), np.arange(rows)
        if max_columns is not None:
            x, y = subsample(columns, max_columns), subsample(rows, max_columns - 1)
        ids = board.lattice[y][:, x]
        kept = board.points[ids]
        step = (float(np.diff(kept[0, :, 0]).max()), float(np.diff(kept[:, 0, 1]).max()))
        points = kept.reshape(-1, 3)
        support = (board.support[ids.ravel()] - points[:, None, None])[..., :2].transpose(1, 2, 3, 0)
        multiplicity = rows * columns / len(points)
        return cls(np.ascontiguousarray(points.T), len(y), len(x), step, multiplicity, support)


def r_sequence(count: int, offset: int) -> Array:
    """Low-discrepancy points (count, 6) of the unit cube: a Kronecker sequence, Roberts' R6 (2018)."""
    root = 1.1127756842787055  # of x^7 = x + 1
    alpha = root ** -np.arange(1.0, 7.0)
    return np.asarray((0.5 + (np.arange(count)[:, None] + 1 + offset * count) * alpha) % 1.0)


@dataclass(frozen=True, eq=False)
class RayGrid:
    """Unit rays (rows, columns, 3), or NaN, from corner to corner of an image, to interpolate.

    A candidate's centre need not be exact. `focal`: px per radian at the axis, along x.
    """

    rays: Array
    focal: float
    img_size: tuple[int, int]

    @classmethod
    def of(cls, camera: Camera) -> "RayGrid":
        """Rays of a camera."""
        w, h = camera.img_size
        x, y = np.linspace(-0.5, w - 0.5, 17), np.linspace(-0.5, h - 0.5, 13)
        rays = models.get(camera.model).unproject(camera.intrinsics, np.stack(np.meshgrid(x, y)))
        return cls(np.ascontiguousarray(rays.transpose(1, 2, 0)), camera.focal[0], camera.img_size)

    def interpolate(self, x: Array, y: Array) -> Array:
        """Unit rays (c, 3), or NaN, at shares x, y (c,) in [0, 1] of the image's width and height."""
        rows, columns, _ = self.rays.shape
        x, y = x * (columns - 1), y * (rows - 1)
        i, j = np.minimum(x.astype(int), columns - 2), np.minimum(y.astype(int), rows - 2)
        a, b = (x - i)[:, None], (y - j)[:, None]
        upper = self.rays[j, i] * (1 - a) + self.rays[j, i + 1] * a
        lower = self.rays[j + 1, i] * (1 - a) + self.rays[j + 1, i + 1] * a
        ray = upper * (1 - b) + lower * b
        return np.asarray(ray / np.sqrt(np.einsum("ci,ci->c", ray, ray))[:, None])


def poses_from_unit_cube(unit: Array, board: Board, rays: RayGrid, limits: PoseLimits) -> Poses:
    """Poses (c) of points (c, 6) of the unit cube: centre x, y, width, tilt, azimuth of the tilt, roll.

    A pose whose centre has no ray gets NaN translations.
    """
    ray = rays.interpolate(concentrate_centre(unit[:, 0]), concentrate_centre(unit[:, 1]))
    tilt, width = tilt_and_width_from_unit_cube(unit, limits)
    tilt, length = np.radians(tilt), width * max(rays.img_size)
    azimuth = 2 * np.pi * unit[:, 4]
    roll = np.radians(limits.max_roll_deg) * (2 * concentrate_centre(unit[:, 5]) - 1)
    (width_px, height_px), (columns, rows) = rays.img_size, board.size
    if (columns - rows) * (width_px - height_px) < 0:  # the longer side of the board along the image's
        roll = roll + np.pi / 2
    zero = np.zeros(len(unit))
    tilted = rotation.matrix(np.stack([tilt * np.cos(azimuth), tilt * np.sin(azimuth), zero], axis=1))
    rolled = rotation.matrix(np.stack([zero, zero, roll], axis=1))
    r = rotation.rotation_to_ray(ray) @ tilted @ rolled
    distance = rays.focal * max(board.size) / length
    center = board.outline.mean(axis=0)
    return Poses(r, ray * distance[:, None] - r @ center)


def tilt_and_width_from_unit_cube(unit: Array, limits: PoseLimits) -> tuple[Array, Array]:
    """Tilts (c,), degrees, and widths (c,), board / image.

    Large ones, which carry most information, are denser.
    """
    low, high = limits.width
    return limits.max_tilt_deg * np.sqrt(unit[:, 3]), low + (high - low) * np.sqrt(unit[:, 2])


def concentrate_centre(u: Array) -> Array:
    """Points of [0, 1], moved so that they become denser in the centre."""
    v = 2 * u - 1
    return 0.5 + 0.5 * v * np.sqrt(np.abs(v))


def check_visibility(
    p: Array, q: Array, axes: Array, corners: CornerGrid, camera: Camera, limits: PoseLimits
) -> tuple[Array, Mask]:
    """Probability (c, n) that corners are found, and poses (c,) that respect the limits; others have 0.

    A detector finds a corner if the image contains it and what identifies it (`Board.support`). A hand
    misses the pose: a point on the border of the image is seen in half of the cases, one at
    `limits.border` from it always, or never. `p` (c, 3, n): corners in the camera frame; `q` (c, 2, n):
    their pixels; `axes` (c, 3, 3): board -> camera.
    """
    model, w = models.get(camera.model), camera.img_size[0]
    border = limits.border * w
    inside = distance_to_border(q.transpose(0, 2, 1), camera.img_size)
    inside[~model.valid(np.asarray(camera.distortion), p.transpose(1, 0, 2))] = -np.inf
    possible = inside > -border
    pixels = q.reshape(-1, 2, corners.rows, corners.columns)
    shown = possible.reshape(-1, corners.rows, corners.columns)
    # The spacing of invisible corners does not count: outside the domain their places are arbitrary.
    shown_across, shown_down = shown[:, :, 1:] & shown[:, :, :-1], shown[:, 1:] & shown[:, :-1]
    across, down = np.diff(pixels, axis=3), np.diff(pixels, axis=2)
    spacing = np.minimum(
        np.sqrt(np.where(shown_across, (across**2).sum(axis=1), np.inf).min(axis=(1, 2))) / corners.step[0],
        np.sqrt(np.where(shown_down, (down**2).sum(axis=1), np.inf).min(axis=(1, 2))) / corners.step[1],
    )
    cos_incidence = np.einsum("ci,cin->cn", axes[:, :, 2], p) / np.sqrt(np.einsum("cin,cin->cn", p, p))
    feasible = spacing >= limits.min_spacing * w
    max_incidence = np.radians(limits.max_incidence_deg)
    feasible &= np.where(possible, cos_incidence, 1.0).min(axis=1) >= np.cos(max_incidence)
    feasible &= possible.mean(axis=1) >= limits.min_visible
    use = np.flatnonzero(feasible)
    # What a detector needs around the corners, (3, u, g, m, n) and projected (2, u * g * m * n).
    offsets = np.einsum("cij,gmjn->icgmn", axes[use, :, :2], corners.support)
    around = p[use].transpose(1, 0, 2)[:, :, None, None] + offsets
    needed = model.project(camera.intrinsics, around.reshape(3, -1))
    needed_inside = distance_to_border(needed.T, camera.img_size).reshape(offsets.shape[1:])
    least = np.minimum(inside[use], needed_inside.min(axis=2).max(axis=1))
    found = np.zeros(inside.shape)
    found[use] = np.clip(0.5 + least / (2 * border), 0, 1)
    return found, feasible & (found.mean(axis=1) >= limits.min_visible)


def distance_to_border(q: Array, img_size: tuple[int, int]) -> Array:
    """Distance (...) of pixels (..., 2) from the border of the image, px; negative outside of it."""
    w, h = img_size
    x, y = q[..., 0], q[..., 1]
    distance = np.minimum(np.minimum(x, w - 1 - x), np.minimum(y, h - 1 - y))
    return np.where(np.isfinite(distance), distance, -np.inf)


def is_in_front(poses: Poses, board: Board, rays: RayGrid) -> Mask:
    """True if all of the board, visible or not, is in front of the camera and faces it (c,)."""
    p = poses.r @ board.outline.T + poses.t[:, :, None]
    length = np.sqrt(np.einsum("cin,cin->cn", p, p))
    half_view = np.degrees(np.arccos(np.nanmin(rays.rays[:, :, 2], initial=1.0)))
    widest = np.radians(min(half_view + MAX_OUTSIDE_VIEW_DEG, 180))
    front = (p[:, 2] / length).min(axis=1) >= np.cos(widest)
    front &= np.einsum("ci,cin->cn", poses.r[:, :, 2], p).min(axis=1) > 0
    return np.asarray(front, dtype=np.bool_)
