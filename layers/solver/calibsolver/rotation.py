"""Rotations: vectors (axis times angle, radians) and matrices, batched."""

import numpy as np

from .arrays import Array

MIN_HALF_ANGLE_RAD = 1e-150
"""So that sin(half) / half is 1 instead of 0/0."""
CROSS = np.array([[0.0, 0, 0, 0, 0, -1, 0, 1, 0], [0, 0, 1, 0, 0, 0, -1, 0, 0], [0, -1, 0, 1, 0, 0, 0, 0, 0]])
"""Matrix (3, 9) from a vector to its cross-product matrix, row by row."""


def skew(v: Array) -> Array:
    """Cross-product matrices: (..., 3) -> (..., 3, 3) with ``skew(v) @ w == cross(v, w)``."""
    m: Array = (v @ CROSS).reshape(*v.shape[:-1], 3, 3)
    return m


def matrix(rvec: Array) -> Array:
    """Rotation matrices of rotation vectors (..., 3) -> (..., 3, 3), Rodrigues' formula."""
    # With c, s the cosine and sine of half the angle and u = 2 s axis: (2 c^2 - 1) 1 + c [u]x + u u' / 2.
    half = np.maximum(np.sqrt(np.add.reduce(rvec * rvec, axis=-1, keepdims=True)) / 2, MIN_HALF_ANGLE_RAD)
    u, c = rvec * (np.sin(half) / half), np.cos(half)
    rotation: Array = u[..., :, None] * (u / 2)[..., None, :]
    flat = rotation.reshape(*rvec.shape[:-1], 9)
    flat += (c * u) @ CROSS
    flat[..., ::4] += 2 * c * c - 1
    return rotation


def vector(r: Array) -> Array:
    """Rotation vectors of rotation matrices (..., 3, 3) -> (..., 3), angle in [0, pi].

    By the unit quaternion of largest component, which keeps full precision at 0 and at pi.
    """
    m = r.reshape(-1, 3, 3)
    diagonal = np.diagonal(m, axis1=1, axis2=2)
    trace = diagonal.sum(axis=1)
    # 4 q q^T, rows and columns (w, x, y, z)
    k = np.empty((len(m), 4, 4))
    k[:, 0, 0] = 1 + trace
    k[:, 0, 1:] = k[:, 1:, 0] = m[:, (2, 0, 1), (1, 2, 0)] - m[:, (1, 2, 0), (2, 0, 1)]
    k[:, 1:, 1:] = m + m.transpose(0, 2, 1)
    k.reshape(len(m), -1)[:, 5::5] += (1 - trace)[:, None]
    best = np.argmax(np.diagonal(k, axis1=1, axis2=2), axis=1)
    q = k[np.arange(len(m)), best]
    q *= np.where(q[:, :1] < 0, -1.0, 1.0) / np.sqrt((q * q).sum(axis=1, keepdims=True))
    s = np.sqrt((q[:, 1:] ** 2).sum(axis=1, keepdims=True))
    angle = 2 * np.arctan2(s, q[:, :1])
    factor = np.where(s > 1e-12, angle / np.maximum(s, 1e-12), 2.0)
    out: Array = (q[:, 1:] * factor).reshape(*r.shape[:-2], 3)
    return out


def nearest(m: Array) -> Array:
    """Closest rotation matrices to (..., 3, 3) in the Frobenius norm (orthogonal Procrustes, Kabsch)."""
    u, _, vt = np.linalg.svd(m)
    sign = np.linalg.det(u @ vt)
    u = u.copy()
    u[..., :, 2] *= sign[..., None]
    closest: Array = u @ vt
    return closest


def rotation_to_ray(ray: Array) -> Array:
    """Shortest rotations (..., 3, 3) that take the optical axis (0, 0, 1) to unit rays (..., 3).

    Of rays within 1e-4 radians of (0, 0, -1) there is no shortest one, and the result is not a rotation.
    """
    x, y, z = np.moveaxis(ray, -1, 0)
    s = 1 / np.maximum(1 + z, 1e-9)  # Rodrigues' formula with sin = |(x, y)|, (1 - cos) / sin^2 = 1 / (1 + z)
    r = np.empty((*ray.shape, 3))
    r[..., 0, 0], r[..., 0, 1], r[..., 0, 2] = 1 - x * x * s, -x * y * s, x
    r[..., 1, 0], r[..., 1, 1], r[..., 1, 2] = -x * y * s, 1 - y * y * s, y
    r[..., 2, 0], r[..., 2, 1], r[..., 2, 2] = -x, -y, z
    return r
