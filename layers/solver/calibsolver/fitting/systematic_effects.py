"""Systematic effects within a view: a board that bends, and a hand that moves while rows are read out.

Each shifts all corners of a view together, by a few numbers: three quadratic terms of the board's height, and
six of its velocity during the readout, in proportion to the row. Standard deviations are those of boards of
paper in hands.
"""

import numpy as np

from ..arrays import Array, Mask
from .normal_equations import POSE_SIZE, RIDGE, Poses, solve_or_nan

BEND_SIZE = 3
"""Terms of bend: height by x^2, xy and y^2."""
EFFECTS_SIZE = BEND_SIZE + POSE_SIZE
"""The terms of bend, then the motion: three of rotation, three of translation."""
SAG_STD_BOARDS = 0.003
"""Height of each quadratic term at the board's rim / longer side."""
SHUTTER_ROTATION_STD_RAD = 0.001
"""Rotation about each axis from the middle row of the image to an outermost one."""
SHUTTER_SHIFT_STD_BOARDS = 0.001
"""Translation along each axis meanwhile / longer side of the board."""


def row_position(y: Array, img_height: int) -> Array:
    """Rows (...) of pixels, from the middle of the image, in halves of its height."""
    return (y - (img_height - 1) / 2) / max(img_height / 2, 1.0)


def displacements(by_pose: Array, poses: Poses, points: Array, row: Array) -> Array:
    """Displacements (EFFECTS_SIZE, 2, v, n), px, by a standard deviation of each effect.

    `by_pose` (6, 2, v, n) are derivatives of the pixels, `points` (v, 3, n) or, for all views, (3, n), board
    frame, `row` (v, n) as `row_position`.
    """
    x, y = points[..., 0, :], points[..., 1, :]
    half = _half_extent(points)
    across, down = (each - each.sum(axis=-1, keepdims=True) / each.shape[-1] for each in (x, y))
    normal = poses.r[:, :, 2] * (SAG_STD_BOARDS * 2 / half)
    by_height = by_pose[3] * normal[:, :1]
    by_height += by_pose[4] * normal[:, 1:2]
    by_height += by_pose[5] * normal[:, 2:]
    out = np.empty((EFFECTS_SIZE, *by_pose.shape[1:]))
    for i, term in enumerate((across * across, across * down, down * down)):
        np.multiply(by_height, term, out=out[i])
    out[BEND_SIZE:] = motion(by_pose, points, row)
    return out


def motion(by_pose: Array, points: Array, row: Array) -> Array:
    """Displacements (POSE_SIZE, 2, v, n), px, by a standard deviation of motion; see `displacements`."""
    out = np.empty_like(by_pose)
    np.multiply(by_pose[:3], row * SHUTTER_ROTATION_STD_RAD, out=out[:3])
    longer = 2 * _half_extent(points)
    np.multiply(by_pose[3:], row * (SHUTTER_SHIFT_STD_BOARDS * longer), out=out[3:])
    return out


def _half_extent(points: Array) -> float:
    """Half the longer extent of points (..., 3, n)."""
    x, y = points[..., 0, :], points[..., 1, :]
    return max(float(max(x.max() - x.min(), y.max() - y.min())) / 2, 1e-9)


def explained_points(
    rows: Array, effects: Array, good: Mask, among: Mask, sigma: float, limit: float
) -> Mask:
    """The `good` points (v, n), and those `among` the others that effects on their view explain.

    These are no wrong corners.

    Pose and `effects` (EFFECTS_SIZE, 2, v, n) are fitted to the good points of each view, and predict the
    others, up to the `limit`, px. `rows` (... + 7, 2, v, n) end with the derivatives by the pose and the
    residuals, of noise `sigma`, px.
    """
    if not (among & ~good).any():
        return good
    design = np.concatenate([rows[-POSE_SIZE - 1 : -1], effects, rows[-1:]]).transpose(2, 0, 1, 3)
    flat, fitted = (
        each.reshape(len(each), len(each[0]), -1) for each in (design, design * good[:, None, None])
    )
    products = fitted @ flat.transpose(0, 2, 1)
    normal = products[:, :-1, :-1].copy()
    diagonal = normal.reshape(len(flat), -1)[:, :: POSE_SIZE + EFFECTS_SIZE + 1]
    diagonal[:, :POSE_SIZE] += RIDGE * diagonal[:, :POSE_SIZE] + 1e-200
    diagonal[:, POSE_SIZE:] += sigma**2
    solution = solve_or_nan(normal, products[:, :-1, -1:])
    left = flat[:, -1] - (solution.transpose(0, 2, 1) @ flat[:, :-1])[:, 0]
    square = np.sum(left.reshape(len(flat), 2, -1) ** 2, axis=1)
    return np.asarray(good | (among & (square < limit**2)))
