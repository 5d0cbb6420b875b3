"""Variances of the systematic effects, from their moments in the residuals (Rao 1970).

Motion differs between clusters of views, the bend of the board is the same in all.
"""

import math
from dataclasses import dataclass

import numpy as np

from ..arrays import Array, dot
from . import normal_equations
from .systematic_effects import BEND_SIZE, EFFECTS_SIZE

MIN_DETERMINANT = 1e-9
"""Determinant of the equations of moments / product of their diagonal, below which either effect explains all
that the other does."""


@dataclass(frozen=True, eq=False)
class EffectMoments:
    """Products of the systematic effects with the residuals and with the whitened intrinsics, at unit noise.

    Attributes
    ----------
    by_move, by_bend
        Pull on the intrinsics by the motion in each cluster, (c, p, 6), and by the bend of all, (p, 3).
    motion, bend
        Effects that remain in the residuals: of motion (c, 6, 6), of the bend (3, 3).
    cross
        (c, 6, 3) of the bend in the motion's.
    of_moves, of_bend
        Products of the residuals with the effects, (c, 6) and (3,).
    z
        (c, 6, 6) Gram matrices of the motion.
    """

    by_move: Array
    by_bend: Array
    motion: Array
    bend: Array
    cross: Array
    of_moves: Array
    of_bend: Array
    z: Array

    @classmethod
    def of(cls, gram: Array, pull: Array, sigma: float) -> "EffectMoments":
        """Moments from Gram matrices of effects and residuals (c, 10, 10) and the effects' pull (c, p, 9)."""
        bends, moves = slice(BEND_SIZE), slice(BEND_SIZE, EFFECTS_SIZE)
        by_move, by_bend = pull[:, :, moves], pull[:, :, bends].sum(axis=0)
        back, total, z = by_move.transpose(0, 2, 1), gram.sum(axis=0), gram[:, moves, moves]
        return cls(
            by_move,
            by_bend,
            z - back @ by_move,
            total[bends, bends] - by_bend.T @ by_bend,
            gram[:, moves, bends] - back @ by_bend,
            gram[:, moves, -1] / sigma,
            total[bends, -1] / sigma,
            z,
        )

    def variances(self) -> tuple[float, float]:
        """Estimate the variances of motion and bend, in units of sigma^2, from their moments."""
        # Where there is no effect, noise alone makes the sum of squares exceed its mean by one deviation.
        noise = float(np.einsum("vii->", self.motion)) + math.sqrt(2 * dot(self.motion, self.motion))
        bend_noise = float(np.trace(self.bend)) + math.sqrt(2 * dot(self.bend, self.bend))
        excess = (
            dot(self.of_moves, self.of_moves) - noise,
            dot(self.of_bend, self.of_bend) - bend_noise,
        )
        both = (self.by_move @ self.by_move.transpose(0, 2, 1)).sum(axis=0)
        # z z - 2 z taken, with taken = z - motion
        by_motion = 2 * dot(self.z, self.motion) - dot(self.z, self.z) + dot(both, both)
        return _variances(excess, by_motion, dot(self.cross, self.cross), dot(self.bend, self.bend))

    def covariances(self, m: float, s: float) -> tuple[Array, Array]:
        """Covariance of the whitened gradient by the motion in each cluster (c, p, p), by the bend (p, p).

        Both / sigma^2, of variances of motion and bend.
        """
        views, size, _ = self.by_move.shape
        pull = m * (self.by_move @ self.by_move.transpose(0, 2, 1)) if m else np.zeros((views, size, size))
        if s == 0:
            return pull, np.zeros_like(pull[0])
        crossed = self.cross.reshape(-1, BEND_SIZE)
        observed = s * self.bend @ self.bend + self.bend + m * (crossed.T @ crossed)
        gain = s * normal_equations.solve_or_nan(observed, self.bend)
        mean = gain.T @ self.of_bend
        second = np.outer(mean, mean) + s * (np.eye(BEND_SIZE) - gain.T @ self.bend)
        bent = self.by_bend @ (second + second.T) / 2 @ self.by_bend.T
        return pull, bent if np.isfinite(bent).all() else np.zeros_like(bent)


def _variances(excess: tuple[float, float], one: float, cross: float, other: float) -> tuple[float, float]:
    """Solve the equations of moments [[one, cross], [cross, other]] x = excess for variances, at least 0."""
    determinant = one * other - cross**2
    if determinant > MIN_DETERMINANT * one * other:
        m = (other * excess[0] - cross * excess[1]) / determinant
        s = (one * excess[1] - cross * excess[0]) / determinant
        if m >= 0 and s >= 0:
            return m, s
        if m < 0 <= s:
            return 0.0, max(excess[1], 0.0) / other
    return (max(excess[0], 0.0) / one if one > 0 else 0.0), 0.0
