"""Systematic effects within a view: a board that bends, and a hand that moves while rows are read out.

Each shifts all corners of a view together, in a way that is known up to a few numbers: three quadratic terms
of the board's height, and six of its velocity during the readout, in proportion to the row. Their standard
deviations are those in the hands of people with boards of paper.
"""

import numpy as np

from ..arrays import Array
from .normal_equations import POSE_SIZE, Poses

BEND_SIZE = 3
"""Terms of bend: height by x^2, xy and y^2."""
EFFECTS_SIZE = BEND_SIZE + POSE_SIZE
"""Effects: the terms of bend, then the motion, three of rotation and three of translation."""
SAG_STD_BOARDS = 0.003
"""Standard deviation of the height of each quadratic term at the board's rim / longer side."""
SHUTTER_ROTATION_STD_RAD = 0.001
"""Standard deviation of the rotation about each axis from the middle row of the image to an outermost one."""
SHUTTER_SHIFT_STD_BOARDS = 0.001
"""Standard deviation of the translation along each axis meanwhile / longer side of the board."""


def row_position(y: Array, img_height: int) -> Array:
    """Rows (...) of pixels, from the middle of the image, in halves of its height."""
    position: Array = (y - (img_height - 1) / 2) / max(img_height / 2, 1.0)
    return position


def displacements(by_pose: Array, poses: Poses, points: Array, row: Array) -> Array:
    """Displacements (EFFECTS_SIZE, 2, v, n), px, by a standard deviation of each effect.

    Parameters
    ----------
    by_pose
        (6, 2, v, n) derivatives of the pixels by rotation and translation.
    points
        (v, 3, n) or, for all views, (3, n); board frame.
    row
        (v, n) as `row_position`.
    """
    x, y = points[..., 0, :], points[..., 1, :]
    half = max(float(max(x.max() - x.min(), y.max() - y.min())) / 2, 1e-9)
    across, down = (each - each.sum(axis=-1, keepdims=True) / each.shape[-1] for each in (x, y))
    normal = poses.r[:, :, 2] * (SAG_STD_BOARDS * 2 / half)
    by_height = by_pose[3] * normal[:, :1]
    by_height += by_pose[4] * normal[:, 1:2]
    by_height += by_pose[5] * normal[:, 2:]
    out = np.empty((EFFECTS_SIZE, *by_pose.shape[1:]))
    for i, term in enumerate((across * across, across * down, down * down)):
        np.multiply(by_height, term, out=out[i])
    np.multiply(by_pose[:3], row * SHUTTER_ROTATION_STD_RAD, out=out[BEND_SIZE : BEND_SIZE + 3])
    np.multiply(by_pose[3:], row * (SHUTTER_SHIFT_STD_BOARDS * 2 * half), out=out[BEND_SIZE + 3 :])
    return out
