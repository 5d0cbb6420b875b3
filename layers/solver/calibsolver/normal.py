"""Normal equations of the reprojection error, with the poses eliminated.

Per view the Jacobian is [A | B] with A by the intrinsics (p) and B by the pose (6: a small rotation applied
from the left in the camera frame, then the translation). Eliminating the pose leaves S = A'A - A'B (B'B)^-1
B'A, what the view tells about the intrinsics alone (Schur complement; Triggs et al., "Bundle adjustment",
2000).
"""

from dataclasses import dataclass

import numpy as np

from . import rotation
from .arrays import Array
from .models import Model


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
    rotated = poses.r @ points
    p = rotated + poses.t[:, :, None]
    q, by_k, by_p = model.jacobian(k, p.transpose(1, 0, 2))
    v, n = len(poses.t), points.shape[-1]
    size = model.size
    j = np.empty((v, size + 6, 2, n))
    j[:, :size] = by_k.transpose(2, 0, 1, 3)
    b = by_p.transpose(2, 0, 1, 3)  # (v, 3, 2, n)
    j[:, size + 3 :] = b
    # d(exp(w) Y)/dw = w x Y, and b . (w x Y) = w . (Y x b)
    y = rotated[:, :, None, :]
    j[:, size] = y[:, 1] * b[:, 2] - y[:, 2] * b[:, 1]
    j[:, size + 1] = y[:, 2] * b[:, 0] - y[:, 0] * b[:, 2]
    j[:, size + 2] = y[:, 0] * b[:, 1] - y[:, 1] * b[:, 0]
    return q.transpose(1, 0, 2), j


def information(j: Array, weights: Array) -> Array:
    """Compute what views tell of the intrinsics, S (v, p, p): Jacobian (v, p + 6, 2, n), weights (v, n)."""
    v, width, _, n = j.shape
    weighted = (j * np.sqrt(weights)[:, None, None, :]).reshape(v, width, 2 * n)
    return eliminate(weighted @ weighted.transpose(0, 2, 1))


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
