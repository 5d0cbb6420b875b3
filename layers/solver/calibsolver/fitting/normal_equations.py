"""Normal equations of the reprojection error: Jacobians, Fisher information, Schur complement.

Per view the Jacobian is [A | B] with A by the intrinsics (p) and B by the pose (6: a small rotation applied
from the left in the camera frame, then the translation). The Schur complement of the pose, S = A'A - A'B
(B'B)^-1 B'A, is the Fisher information of the intrinsics at unit noise (Triggs et al., "Bundle adjustment",
2000).

`rows` are a Jacobian transposed, one plane in memory for each unknown: (p + 6, 2, v, n), the intrinsics
first.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .. import rotation
from ..arrays import Array, IntArray, Mask
from ..models import Model

POSE_SIZE = 6
RIDGE = 1e-15
"""Relative ridge of the poses' Gram matrices, which rounding may make singular."""


MAX_SMALL_PRODUCT = 10**6
"""Multiplications of a matrix product up to which OpenBLAS does not copy its factors first."""


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

    def retract(self, step: Array) -> "Poses":
        """Poses after small steps (v, 6): rotated from the left, then shifted."""
        return Poses(rotation.matrix(step[:, :3]) @ self.r, self.t + step[:, 3:])

    def replace(self, index: IntArray | Mask, poses: "Poses") -> "Poses":
        """Poses with those of some views replaced."""
        r, t = self.r.copy(), self.t.copy()
        r[index], t[index] = poses.r, poses.t
        return Poses(r, t)

    def subset(self, index: IntArray | Mask | slice) -> "Poses":
        """Poses of some views."""
        return Poses(self.r[index], self.t[index])

    def camera_points(self, points: Array) -> Array:
        """Points (v, 3, n), board frame -> camera frame."""
        return self.r @ points + self.t[:, :, None]


def linearize(
    model: Model, k: Array, poses: Poses, points: Array, extra_rows: int, rows_before: int = 0
) -> tuple[Array, Array]:
    """Pixels (2, v, n) and rows (rows_before + p + 6 + extra_rows, 2, v, n) of the Jacobian.

    The extra ones are empty.
    """
    views, n, size = len(poses.r), points.shape[-1], model.size
    rotated = np.empty((3, views, n))
    np.matmul(poses.r, points, out=rotated.transpose(1, 0, 2))
    every = np.empty((rows_before + size + 6 + extra_rows, 2, views, n))
    rows = every[rows_before:]
    by_p = rows[size + 3 : size + 6]
    q = model.fill_jacobian(k, rotated + poses.t.T[:, :, None], rows[:size], by_p)
    # d(exp(w) Y)/dw = w x Y, and b . (w x Y) = w . (Y x b)
    x, y, z = rotated
    bx, by, bz = by_p
    turn = rows[size : size + 3]
    np.multiply(y, bz, out=turn[0])
    turn[0] -= z * by
    np.multiply(z, bx, out=turn[1])
    turn[1] -= x * bz
    np.multiply(x, by, out=turn[2])
    turn[2] -= y * bx
    return q, every


def gram_matrices(rows: Array) -> Array:
    """Gram matrices (v, m, m) of rows (m, 2, v, n), summed over the points of each view."""
    across, down = rows[:, 0].transpose(1, 0, 2), rows[:, 1].transpose(1, 0, 2)
    h: Array = across @ across.transpose(0, 2, 1)
    h += down @ down.transpose(0, 2, 1)
    return h


def schur_complement(h: Array, nuisance: int = 0) -> Array:
    """Schur complement (v, p, p) of the last variables of (v, p + 6 + nuisance, p + 6 + nuisance).

    These are the six of a pose, then `nuisance` variables of standard deviation 1.
    """
    size = h.shape[-1] - POSE_SIZE - nuisance
    b = h[:, size:, size:] + np.diag([0.0] * POSE_SIZE + [1.0] * nuisance)
    w = h[:, size:, :size]
    # The smallest ridge that keeps a view without any points from being singular.
    ridge = 1e-13 * np.diagonal(b, axis1=1, axis2=2) + 1e-200
    scale = 1 / np.sqrt(np.diagonal(b, axis1=1, axis2=2) + ridge)
    unit = b * scale[:, :, None] * scale[:, None, :]
    ws = w * scale[:, :, None]
    return h[:, :size, :size] - ws.transpose(0, 2, 1) @ eliminate_poses(unit, ws, 1e-13)


def eliminate_poses(h_pp: Array, h_pc: Array, damping: float | Array) -> Array:
    """Solve (H_pp + damping I) X = H_pc for X (v, 6, m), with one damping or (v,); of scaled unknowns."""
    lifted = h_pp.copy()
    diagonal = lifted.reshape(len(lifted), -1)[:, :: h_pp.shape[-1] + 1]
    diagonal += damping if isinstance(damping, float) else damping[:, None]
    return solve_or_nan(lifted, h_pc)


@dataclass(frozen=True, eq=False)
class Projection:
    """Rows A of a Jacobian less what changes of the poses, of columns B, explain.

    `left` (v, m, 2n) is A' less its orthogonal projection onto B, `by_pose` (v, 6, m) B'A, `pose_gram` (v, 6,
    6) B'B, `solved` (v, 6, m) X of B'B X = B'A.
    """

    left: Array
    by_pose: Array
    pose_gram: Array
    solved: Array

    @classmethod
    def of(cls, rows: Sequence[Array], used: Mask | None = None) -> "Projection":
        """Project rows (..., 2, v, n), m + 6 together, those of the pose last.

        Of points `used` (v, n), or all.

        A - BX is formed before its products are taken, so that nearly collinear parameters lose nothing by
        cancellation.
        """
        flat = by_views(rows, used)
        size = flat.shape[1] - POSE_SIZE
        b = flat[:, size:]
        products = b @ flat.transpose(0, 2, 1)
        by_pose, pose_gram = products[:, :, :size], products[:, :, size:]
        x = _least_ridge_solution(pose_gram, by_pose)
        left = flat[:, :size] - x.transpose(0, 2, 1) @ b
        return cls(left, by_pose, pose_gram, x)


def products_of_rows(a: Array) -> Array:
    """Products (v, m, m) of the rows of matrices (v, m, n) with one another.

    Of a copy, because BLAS has a slow routine for a matrix times its own transpose.
    """
    return a @ a.copy().transpose(0, 2, 1)


def products_of_long_rows(a: Array, b: Array) -> Array:
    """Products (m, p) of the rows of (m, n) and (p, n), n large, in parts that BLAS is fastest with."""
    step = max(MAX_SMALL_PRODUCT // max(len(a) * len(b), 1), 1)
    out: Array = a[:, :step] @ b[:, :step].T
    for begin in range(step, a.shape[1], step):
        part = slice(begin, begin + step)
        out += a[:, part] @ b[:, part].T
    return out


def by_views(rows: Sequence[Array], used: Mask | None = None) -> Array:
    """Rows (..., 2, v, n), m together, by views: (v, m, 2n), 0 where points (v, n) are not used."""
    _, _, views, n = rows[0].shape
    flat, begin = np.empty((views, sum(len(part) for part in rows), 2, n)), 0
    for part in rows:
        flat[:, begin : begin + len(part)] = part.transpose(2, 0, 1, 3)
        begin += len(part)
    if used is not None:
        view, point = np.nonzero(~used)
        flat[view, :, :, point] = 0
    return flat.reshape(views, begin, 2 * n)


def projected_gram_matrices(rows: Sequence[Array], used: Mask | None = None) -> Array:
    """Gram matrices (v, m, m) of `Projection.left`: faster, but they lose digits by cancellation."""
    flat = by_views(rows, used)
    gram = products_of_rows(flat)
    size = flat.shape[1] - POSE_SIZE
    across = gram[:, size:, :size]
    left: Array = gram[:, :size, :size]
    left -= across.transpose(0, 2, 1) @ _least_ridge_solution(gram[:, size:, size:], across)
    return left


def _least_ridge_solution(gram: Array, across: Array) -> Array:
    lifted = gram.copy()
    diagonal = lifted.reshape(len(gram), -1)[:, :: POSE_SIZE + 1]
    diagonal *= 1 + RIDGE
    diagonal += 1e-200
    return solve_or_nan(lifted, across)


def residual_jacobian(rows: Array) -> Array:
    """Part (v, 2n, p) of rows (p + 6, 2, v, n) by the intrinsics that no change of the poses explains."""
    return Projection.of([rows]).left.transpose(0, 2, 1)


def reduced_information(rows: Array) -> Array:
    """Fisher information (p, p) of the intrinsics from rows (p + 6, 2, v, n), free of cancellation."""
    left = residual_jacobian(rows)
    left = left.reshape(-1, left.shape[2])
    return left.T @ left


@dataclass(frozen=True, eq=False)
class Elimination:
    """Factors of the poses' elimination at one damping, for other gradients."""

    lift: float | Array
    solved: Array
    complement: Array


@dataclass(frozen=True, eq=False)
class System:
    """Damped normal equations of one linearization, solved by the Schur complement of the poses.

    In the blocks of Triggs et al. (2000), c the a free intrinsics, p the poses; each unknown is scaled to a
    unit diagonal (Marquardt 1963).

    Attributes
    ----------
    h_cc, g_c
        Intrinsics, (a, a), and half their gradient (a,).
    h_pp
        Poses, (v, 6, 6).
    h_pc
        Poses by intrinsics, then half the gradient of the poses, (v, 6, a + 1).
    scale_c, scale_p
        Factors from scaled to true unknowns, (a,) and (v, 6).
    """

    h_cc: Array
    g_c: Array
    h_pp: Array
    h_pc: Array
    scale_c: Array
    scale_p: Array

    @classmethod
    def of(cls, rows: Array, weights: Array | None, prior: tuple[Array, Array] | None = None) -> "System":
        """Normal equations of rows (a + 7, 2, v, n), px, the residuals last, of weight (v, n). None: 1.

        The information (a, a) and half gradient (a,) of a prior are added to the intrinsics'.
        """
        size = len(rows) - POSE_SIZE - 1
        if weights is not None:
            rows = rows * np.sqrt(weights)
        shared = rows.reshape(len(rows), -1)
        products = products_of_long_rows(shared[:size], shared)
        h_cc, g_c = products[:, :size], products[:, -1]
        if prior is not None:
            h_cc, g_c = h_cc + prior[0], g_c + prior[1]
        scale_c = 1 / np.sqrt(h_cc.diagonal() + 1e-200)
        across, down = rows[:, 0].transpose(1, 0, 2), rows[:, 1].transpose(1, 0, 2)
        low = across[:, size:-1] @ across.transpose(0, 2, 1)
        low += down[:, size:-1] @ down.transpose(0, 2, 1)
        diagonal = low.reshape(len(low), -1)[:, size :: len(rows) + 1]
        ridge = 1e-13 * np.maximum.reduce(diagonal, axis=1, keepdims=True) + 1e-200
        scale_p = 1 / np.sqrt(diagonal + ridge)
        low *= scale_p[:, :, None]
        h_pp = low[:, :, size:-1] * scale_p[:, None, :]
        h_pc = np.empty((len(h_pp), POSE_SIZE, size + 1))
        np.multiply(low[:, :, :size], scale_c, out=h_pc[:, :, :size])
        h_pc[:, :, size] = low[:, :, -1]
        return cls(h_cc * scale_c[:, None] * scale_c, g_c * scale_c, h_pp, h_pc, scale_c, scale_p)

    def step(self, damping: float) -> tuple[Array, Array, float, Elimination]:
        """Solve for the steps of intrinsics (a,) and poses (v, 6), and the decrease that they predict."""
        dc, dp, elimination = self._solve(damping)
        predicted = -float(self.g_c @ dc) - float(np.vdot(self.h_pc[:, :, -1], dp))
        return dc * self.scale_c, dp * self.scale_p, predicted, elimination

    def pose_steps(self, damping: Array) -> tuple[Array, Array]:
        """Solve for steps (v, 6) of poses at constant intrinsics, with dampings (v,).

        Also returns the decreases (v,) that they predict.
        """
        _, dp, _ = self._solve(damping)
        return dp * self.scale_p, -np.einsum("vi,vi->v", self.h_pc[:, :, -1], dp)

    def solve_with_gradient(self, g_c: Array, g_p: Array, at: Elimination) -> tuple[Array, Array]:
        """Solve for the steps (a,) and (v, 6) down another gradient, (a,) and (v, 6), at the same damping."""
        size = len(self.h_cc)
        y = eliminate_poses(self.h_pp, (g_p * self.scale_p)[:, :, None], at.lift)
        reduced = g_c * self.scale_c - self.h_pc[:, :, :size].reshape(-1, size).T @ y.reshape(-1)
        dc: Array = np.negative(solve_or_nan(at.complement, reduced))
        dp: Array = np.negative(y[:, :, 0] + at.solved @ dc)
        return dc * self.scale_c, dp * self.scale_p

    def slope(self, dc: Array, dp: Array) -> float:
        """Half the derivative of the cost along a step, (a,) and (v, 6)."""
        return float(self.g_c @ (dc / self.scale_c)) + float(np.vdot(self.h_pc[:, :, -1], dp / self.scale_p))

    def curvature(self, dc: Array, dp: Array) -> float:
        """Half the second derivative of the cost along a step, (a,) and (v, 6)."""
        c, p = dc / self.scale_c, (dp / self.scale_p)[:, :, None]
        by_p = 2 * self.h_pc[:, :, :-1] @ c + (self.h_pp @ p)[:, :, 0]
        return float(c @ self.h_cc @ c) + float(np.vdot(p, by_p))

    def length(self, dc: Array, dp: Array) -> float:
        """Length of a step in the scaled unknowns."""
        return float(np.hypot(np.linalg.norm(dc / self.scale_c), np.linalg.norm(dp / self.scale_p)))

    def _solve(self, damping: float | Array) -> tuple[Array, Array, Elimination]:
        """Solve (H + damping I) x = -g for the scaled steps (a,) and (v, 6).

        One damping, or (v,) if no intrinsics are free.
        """
        size, h_pc = len(self.h_cc), self.h_pc
        lift = damping + 1e-14
        solved = eliminate_poses(self.h_pp, h_pc, lift)
        if not size:
            return np.zeros(0), np.negative(solved[:, :, 0]), Elimination(lift, solved[:, :, :0], self.h_cc)
        removed = h_pc.reshape(-1, size + 1).T @ solved.reshape(-1, size + 1)
        complement = self.h_cc - removed[:size, :size]
        complement.reshape(-1)[:: size + 1] += lift
        dc: Array = np.negative(solve_or_nan(complement, self.g_c - removed[:size, size]))
        dp: Array = np.negative(solved[:, :, size] + solved[:, :, :size] @ dc)
        return dc, dp, Elimination(lift, solved[:, :, :size], complement)


def solve_or_nan(a: Array, b: Array) -> Array:
    """Solve a x = b; NaN, a step that is never taken, if there is no solution."""
    try:
        return np.asarray(np.linalg.solve(a, b), dtype=np.float64)
    except np.linalg.LinAlgError:
        return np.full(b.shape, np.nan)
