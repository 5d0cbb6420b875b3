"""Normal equations of the reprojection error, with the poses eliminated.

Per view the Jacobian is [A | B] with A by the intrinsics (p) and B by the pose (6: a small rotation applied
from the left in the camera frame, then the translation). Eliminating the pose leaves S = A'A - A'B (B'B)^-1
B'A, what the view tells about the intrinsics alone (Schur complement; Triggs et al., "Bundle adjustment",
2000).
"""

from dataclasses import dataclass

import numpy as np

from .. import rotation
from ..arrays import Array
from ..models import Model


@dataclass(frozen=True, eq=False)
class Poses:
    """Board to camera: rotations (v, 3, 3) and translations (v, 3), board units."""

    r: Array
    t: Array

    @classmethod
    def of_vectors(cls, rt: Array) -> "Poses":
        """Poses of (v, 6) rvec|tvec."""
        return cls(rotation.matrix(rt[:, :3]), np.array(rt[:, 3:]))

    def vectors(self) -> Array:
        """(v, 6) rvec|tvec."""
        return np.concatenate([rotation.vector(self.r), self.t], axis=1)

    def moved(self, step: Array) -> "Poses":
        """Poses after small steps (v, 6)."""
        return Poses(rotation.matrix(step[:, :3]) @ self.r, self.t + step[:, 3:])

    def camera_points(self, points: Array) -> Array:
        """Points (v, 3, n), board frame -> camera frame."""
        p: Array = self.r @ points + self.t[:, :, None]
        return p


def project(model: Model, k: Array, poses: Poses, points: Array) -> Array:
    """Pixels (v, 2, n) of points (v, 3, n), board frame."""
    p = poses.camera_points(points)
    return model.project(k, p.transpose(1, 0, 2)).transpose(1, 0, 2)


def design(model: Model, k: Array, poses: Poses, points: Array) -> tuple[Array, Array]:
    """Pixels (v, 2, n) of points (v, 3, n), or (3, n) for all, and the Jacobian (v, p + 6, 2, n)."""
    q, rows = linearise(model, k, poses, points, 0)
    return q.transpose(1, 0, 2), rows.transpose(2, 0, 1, 3)


def linearise(model: Model, k: Array, poses: Poses, points: Array, spare: int) -> tuple[Array, Array]:
    """Pixels (2, v, n) and the Jacobian by rows (p + 6 + spare, 2, v, n); the last `spare` are left empty.

    Rows first: each is one plane in memory, which is what the arithmetic on them wants.
    """
    rotated = poses.r @ points
    p = rotated + poses.t[:, :, None]
    q, by_k, by_p = model.jacobian(k, p.transpose(1, 0, 2))
    size = model.size
    rows = np.empty((size + 6 + spare, *q.shape))
    rows[:size] = by_k
    rows[size + 3 : size + 6] = by_p
    # d(exp(w) Y)/dw = w x Y, and b . (w x Y) = w . (Y x b)
    x, y, z = rotated[:, 0], rotated[:, 1], rotated[:, 2]
    bx, by, bz = by_p
    turn = rows[size : size + 3]
    np.multiply(y, bz, out=turn[0])
    turn[0] -= z * by
    np.multiply(z, bx, out=turn[1])
    turn[1] -= x * bz
    np.multiply(x, by, out=turn[2])
    turn[2] -= y * bx
    return q, rows


def squared(rows: Array) -> Array:
    """Products (v, m, m) of rows (m, 2, v, n) with one another, summed over the points of each view."""
    across, down = rows[:, 0].transpose(1, 0, 2), rows[:, 1].transpose(1, 0, 2)
    h: Array = across @ across.transpose(0, 2, 1)
    h += down @ down.transpose(0, 2, 1)
    return h


def information(j: Array, weights: Array) -> Array:
    """Compute what views tell of the intrinsics, S (v, p, p): Jacobian (v, p + 6, 2, n), weights (v, n)."""
    rows = j.transpose(1, 2, 0, 3)
    if not (weights == 1).all():
        rows = rows * np.sqrt(weights)
    return eliminate(squared(rows))


def eliminate(h: Array) -> Array:
    """Schur complement (v, p, p) of the last six variables of (v, p + 6, p + 6)."""
    size = h.shape[-1] - 6
    b = h[:, size:, size:]
    w = h[:, size:, :size]
    # The smallest ridge that keeps a view without any points from being singular.
    ridge = 1e-13 * np.diagonal(b, axis1=1, axis2=2) + 1e-200
    scale = 1 / np.sqrt(np.diagonal(b, axis1=1, axis2=2) + ridge)
    unit = b * scale[:, :, None] * scale[:, None, :] + 1e-13 * np.eye(6)
    ws = w * scale[:, :, None]
    s: Array = h[:, :size, :size] - ws.transpose(0, 2, 1) @ np.linalg.solve(unit, ws)
    return s


def told(rows: Array, size: int) -> Array:
    """Compute what rows (size + 6, 2, v, n) of all views tell of the intrinsics, S (size, size).

    As `eliminate`, but what the poses explain is taken from the rows themselves: of intrinsics that nearly
    replace one another as little is known as rounding would make of differences of products.
    """
    flat = rows.transpose(2, 1, 3, 0).reshape(rows.shape[2], -1, len(rows))
    a, b = flat[:, :, :size], flat[:, :, size:]
    q, _ = np.linalg.qr(b / np.maximum(np.linalg.norm(b, axis=1, keepdims=True), 1e-300))
    left = (a - q @ (q.transpose(0, 2, 1) @ a)).reshape(-1, size)
    s: Array = left.T @ left
    return s
