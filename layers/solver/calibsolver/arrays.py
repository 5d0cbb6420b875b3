"""Array types and small helpers shared by all modules."""

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]

INDISTINCT = 1e-14
"""Eigenvalue of a matrix of unit diagonal below which it is rounding."""


def frozen(values: Any) -> Array:
    """Read-only float64 copy."""
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


def subsample(count: int, max_count: int) -> IntArray:
    """At most `max_count` evenly spaced indices from 0 to `count` - 1, both ends among them."""
    return np.linspace(0, count - 1, min(count, max_count)).round().astype(np.int64)


def dot(one: Array, other: Array) -> float:
    """Sum of the products of the elements of two arrays of one shape."""
    return float(np.vdot(one, other))


def block_diagonal(one: Array, other: Array) -> Array:
    """Matrix of two on its diagonal."""
    (m, n), (p, q) = one.shape, other.shape
    out = np.zeros((m + p, n + q))
    out[:m, :n], out[m:, n:] = one, other
    return out


def symmetric_inverse(a: Array) -> Array:
    """Inverse, positive definite, of matrices (..., p, p), see `whitening`."""
    t = whitening(a)
    inverse: Array = t @ np.swapaxes(t, -1, -2)
    return (inverse + np.swapaxes(inverse, -1, -2)) / 2


def whitening(a: Array) -> Array:
    """Matrices T (..., p, p) with T'AT = 1 for positive definite A; TT' is the inverse of A.

    At a unit diagonal, because entries may differ by many powers of ten; directions that are rounding count
    as known `INDISTINCT` worse than the best. NaN if the matrix is not finite.
    """
    scale = 1 / np.sqrt(np.maximum(np.diagonal(a, axis1=-2, axis2=-1), 1e-300))
    unit = a * scale[..., :, None] * scale[..., None, :]
    finite: Mask = np.asarray(np.isfinite(unit).all(axis=(-2, -1)))
    values, axes = np.linalg.eigh(np.where(finite[..., None, None], unit, 0.0))
    values = np.where(finite[..., None], np.maximum(values, INDISTINCT), np.nan)
    t: Array = scale[..., :, None] * axes / np.sqrt(values)[..., None, :]
    return t
