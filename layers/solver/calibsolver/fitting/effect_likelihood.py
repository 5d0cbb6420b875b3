"""Variance of motion by restricted likelihood, if the residuals consist of bend and motion.

Moments depend mostly on the directions in which an effect moves the corners farthest, so few views determine
the variance poorly. The restricted likelihood (REML; Patterson & Thompson 1971) weighs all directions by
their information. But it needs a correct model: it takes every misfit of the lens for motion in the
directions that move the corners least, on real sets for five times the variance of the moments. So it counts
only if the effect explains more of the residuals' variance than it leaves.
"""

from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from .systematic_effects import BEND_SIZE, EFFECTS_SIZE

MOTIONS = np.concatenate([[0.0], np.geomspace(0.05, 50.0, 8)])
"""Variances of motion that are tried / the variance in people's hands; the others are alike likely before."""
MIN_PIVOT = 1e-12
"""Share of an unknown's information that is taken to be left at least by the effects."""


@dataclass(frozen=True, eq=False)
class EffectLikelihood:
    """Variance of motion, and shares of both effects, by the restricted likelihood.

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

        Parameters
        ----------
        gram
            (c, 10, 10) Gram matrices of effects and residuals of the clusters, px^2.
        pull
            (c, p, 10) of these with the whitened intrinsics: over all clusters and the prior their
            information is 1.
        sigma
            px, standard deviation of one coordinate of a corner, from these residuals.
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
