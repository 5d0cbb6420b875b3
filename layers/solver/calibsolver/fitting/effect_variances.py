"""Variances of the systematic effects: motion, different in clusters of views, and the bend of the board."""

import math
from dataclasses import dataclass

import numpy as np

from ..arrays import Array, dot
from .normal_equations import solve_or_nan
from .systematic_effects import BEND_SIZE, EFFECTS_SIZE

MIN_DETERMINANT = 1e-9
"""Determinant of the equations of moments / product of their diagonal, below which either effect explains
the other."""
MOTIONS = np.concatenate([[0.0], np.geomspace(0.05, 50.0, 8)])
"""Variances of motion that are tried / that in hands; all but 0 are equally likely before."""
MIN_PIVOT = 1e-12


@dataclass(frozen=True, eq=False)
class EffectMoments:
    """Moments of the effects in the residuals (Rao 1970), and in the whitened intrinsics, at unit noise.

    Attributes
    ----------
    by_move, by_bend
        Pull on the intrinsics by the motion in each cluster, (c, p, 6), and by the bend of all, (p, 3).
    motion, bend, cross
        Effects that remain in the residuals, (c, 6, 6), (3, 3), and of the bend in the motion's (c, 6, 3).
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
        """Variances of motion and bend, in units of sigma^2, from their moments."""
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
        """Covariance of the whitened gradient / sigma^2 by motion, (c, p, p), and bend, (p, p)."""
        views, size, _ = self.by_move.shape
        pull = m * (self.by_move @ self.by_move.transpose(0, 2, 1)) if m else np.zeros((views, size, size))
        if s == 0:
            return pull, np.zeros_like(pull[0])
        crossed = self.cross.reshape(-1, BEND_SIZE)
        observed = s * self.bend @ self.bend + self.bend + m * (crossed.T @ crossed)
        gain = s * solve_or_nan(observed, self.bend)
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


@dataclass(frozen=True, eq=False)
class EffectLikelihood:
    """Variance of motion, and shares of both effects, by restricted likelihood.

    REML (Patterson & Thompson 1971) weighs all directions by their information; the moments of few views
    depend mostly on the directions in which an effect moves the corners farthest. But it takes every misfit
    of the lens for motion, on real sets for five times the variance of the moments. So it counts only if the
    effect explains more of the residuals' variance than it leaves.

    Attributes
    ----------
    motion
        Posterior mean of the variance of motion, in units of sigma^2.
    motion_share, bend_share
        Shares of the residuals' variance, of what the other effect leaves, that the effects explain.
    """

    motion: float
    motion_share: float
    bend_share: float

    @classmethod
    def of(cls, gram: Array, pull: Array, sigma: float) -> "EffectLikelihood | None":
        """Evaluate the likelihood on the grid `MOTIONS`, intrinsics and bend free; None: no information.

        `gram` (c, 10, 10) are Gram matrices of effects and residuals of the clusters, px^2, `pull` (c, p, 10)
        of these with the whitened intrinsics.
        """
        size, effects = pull.shape[1], [*range(BEND_SIZE), EFFECTS_SIZE]
        moves = slice(BEND_SIZE, EFFECTS_SIZE)
        total = np.eye(size + BEND_SIZE + 1)
        total[:size, size:-1] = pull[:, :, :BEND_SIZE].sum(axis=0)  # the fit left no gradient: residuals, 0
        total[size:-1, :size] = total[:size, size:-1].T
        total[size:, size:] = gram.sum(axis=0)[effects][:, effects]
        freedom = float(total[-1, -1]) / sigma**2 - BEND_SIZE
        scale = 1 / np.sqrt(total.diagonal() + 1e-300)
        if not (freedom > 1 and np.isfinite(gram).all() and np.isfinite(pull).all()):
            return None
        # In the principal directions of each cluster's motion its covariance is diagonal.
        power, directions = np.linalg.eigh(gram[:, moves, moves])
        rows = np.concatenate([pull[:, :, moves], gram[:, effects, moves]], axis=1) @ directions
        rows = rows.transpose(1, 0, 2).reshape(len(total), -1) * scale[:, None]
        power = np.maximum(power.ravel(), 0.0)
        tried = MOTIONS / sigma**2
        total *= scale[:, None] * scale
        total.flat[:: len(total) + 1] += MIN_PIVOT
        taken = tried[:, None] / (1 + tried[:, None] * power)
        left = total - (rows * taken[:, None]) @ rows.T
        try:
            factor = np.linalg.cholesky(left)
        except np.linalg.LinAlgError:
            return None
        pivots = np.diagonal(factor, axis1=1, axis2=2)
        noise = pivots[:, -1] ** 2 / freedom  # noise^2 / sigma^2 up to one factor, which shares do not feel
        flat = noise + np.sum(factor[:, -1, size:-1] ** 2, axis=1) / (freedom + BEND_SIZE)
        grown = np.log1p(tried[:, None] * power).sum(axis=1)
        likely = -(freedom * np.log(noise) + grown) / 2 - np.log(pivots[:, :-1]).sum(axis=1)
        weights = np.exp(likely[1:] - likely[1:].max())
        weights /= weights.sum()
        mean = float(weights @ noise[1:])
        unit = 1 / (scale[-1] * sigma) ** 2
        return cls(
            float(weights @ (noise[1:] * tried[1:])) * unit,
            1 - mean / float(noise[0]),
            1 - mean / float(weights @ flat[1:]),
        )


def trust(share: float) -> float:
    """Weight of the likelihood: from 0, up to half of the variance explained, to 1, from two thirds on."""
    return min(max(share / max(1 - share, 1e-12) - 1, 0.0), 1.0)
