"""Mixed model of the views: what they share, and what differs between them, with learnt variances.

Linearized, the residuals of a cluster of views are e + A x + Z u + noise. All views share x: the intrinsics
and the shape of the board. Each cluster has its own u: the motion of the hand while the rows are read out
(`systematic_effects`). Shape and motion are random effects (Laird & Ware 1982): their variances and that of
the noise are learnt by expectation maximization of the restricted likelihood (Patterson & Thompson 1971;
Dempster, Laird & Rubin 1977), with weak priors. So a flat board and a still hand cost next to nothing.
"""

from dataclasses import astuple, dataclass, replace

import numpy as np

from ..arrays import Array, dot, symmetric_inverse, whitening
from .systematic_effects import BEND_SIZE, EFFECTS_SIZE

SHAPE_SIZE = 5
"""Numbers of the board's shape: height by x^2, xy and y^2; stretch of x against y; shear."""
MOTION_SIZE = EFFECTS_SIZE - BEND_SIZE
"""Numbers of the motion in a view."""
EXPECTED_HEIGHT, EXPECTED_STRETCH, SHAPE_FREEDOM = 2e-4, 1e-4, 1.0
"""Prior of the standard deviations of heights / board and of stretch, and its degrees of freedom."""
FIRST_HEIGHT, FIRST_STRETCH = 3e-3, 1.5e-3
"""Initial standard deviations: those of boards of paper."""
EXPECTED_MOTION, MOTION_FREEDOM = 0.008, 1.0
"""Prior of the variance of motion / that of a hand, for usual corners, and its degrees of freedom."""
FIRST_MOTION = 1.0
"""Initial variance of motion: the maximization is fast from above and slow from below."""
MAX_LEARNING_STEPS, LEARNING_TOLERANCE = 60, 1e-2
"""Steps of the maximization, and relative change of the variances below which it ends."""


@dataclass(frozen=True)
class Variances:
    """Variances of noise (px^2) and motion; standard deviations of the shape's heights and of its stretch."""

    noise2: float
    motion: float = FIRST_MOTION
    height: float = FIRST_HEIGHT
    stretch: float = FIRST_STRETCH

    def shape_information(self) -> Array:
        """Information (SHAPE_SIZE,) that the prior gives on each number of the shape."""
        std = [self.height] * BEND_SIZE + [self.stretch] * (SHAPE_SIZE - BEND_SIZE)
        return np.array(std) ** -2.0


@dataclass(frozen=True, eq=False)
class Solution:
    """Solution at given variances.

    Attributes
    ----------
    x
        (g,) step of what the views share.
    u
        (c, MOTION_SIZE) motion.
    variances
        After one more step of the maximization.
    """

    x: Array
    u: Array
    variances: Variances


class MixedModel:
    """One linearization of the views.

    Parameters
    ----------
    gram
        (c, g + MOTION_SIZE + 1, ...) Gram matrices of each cluster: shared columns, motion, residuals, px^2;
        the poses projected out.
    count
        Number of residuals less the unknowns of the poses.
    prior
        Information (p, p) of the intrinsics' prior and half its gradient (p,); they come first in x.
    shape
        (SHAPE_SIZE,) shape so far, the last of x.
    floor
        Least variance of the noise, px^2: rounding.
    expected_motion
        Prior of the variance of motion.
    """

    def __init__(
        self,
        gram: Array,
        count: int,
        prior: tuple[Array, Array],
        shape: Array,
        floor: float,
        expected_motion: float,
    ) -> None:
        self.floor = floor
        self.expected_motion = expected_motion
        self.size = size = gram.shape[1] - MOTION_SIZE - 1
        kept = [*range(size), size + MOTION_SIZE]
        moves = slice(size, size + MOTION_SIZE)
        self.count = count
        self.prior, self.gradient = prior
        self.shape = shape
        self.gram = gram[:, kept][:, :, kept]
        self.total = self.gram.sum(axis=0)
        # In the principal directions of each cluster's motion its covariance is diagonal.
        power, self.directions = np.linalg.eigh(gram[:, moves, moves])
        self.power = np.maximum(power, 0.0)
        self.rows = gram[:, kept, moves] @ self.directions

    @property
    def noise2(self) -> float:
        """Variance of the residuals, px^2, motion and all."""
        freedom = max(self.count - self.size, 0.1 * self.count, 1.0)
        variance: float = max(float(self.total[-1, -1]) / freedom, self.floor)
        return variance

    def belief(self, v: Variances) -> tuple[Array, Array]:
        """Information (g, g) and half gradient (g,) of the priors of intrinsics and shape."""
        information, gradient = np.zeros((self.size, self.size)), np.zeros(self.size)
        free = len(self.gradient)
        information[:free, :free], gradient[:free] = self.prior, self.gradient
        certain = v.shape_information()
        information[free:, free:] = np.diag(certain)
        gradient[free:] = certain * self.shape
        return information, gradient

    def solve(self, v: Variances) -> Solution:
        """Solve at the variances `v`, motion marginalised."""
        size = self.size
        total, belief, slope = self._total(v)
        weights = self._weights(v)
        basis = whitening(total[:size, :size] + v.noise2 * belief)
        x = -basis @ (basis.T @ (total[:size, size] + v.noise2 * slope))
        u = -np.einsum("cgm,g->cm", self.rows, np.append(x, 1.0)) * weights
        turned = np.einsum("cij,cj->ci", self.directions, u)
        return Solution(x, turned, self._improved(v, x, u, basis, belief, weights))

    def shape_gain(self, v: Variances) -> float:
        """Decrease of the cost, in squares of the noise, by the shape, with motion allowed for."""
        total, belief, slope = self._total(v)
        information, gradient = total[:-1, :-1] / v.noise2 + belief, total[:-1, -1] / v.noise2 + slope
        free = len(self.gradient)
        both, camera = (whitening(information[:n, :n]).T @ gradient[:n] for n in (self.size, free))
        return dot(both, both) - dot(camera, camera)

    def _total(self, v: Variances) -> tuple[Array, Array, Array]:
        """Gram matrix (g + 1, g + 1), motion marginalised; information and half gradient of the priors."""
        weights = self._weights(v)
        across = self.rows.transpose(1, 0, 2).reshape(self.size + 1, -1)
        return self.total - (across * weights.ravel()) @ across.T, *self.belief(v)

    def _weights(self, v: Variances) -> Array:
        """Variances (c, MOTION_SIZE) of motion given the rest, at unit noise; 0 if there is none."""
        return 1 / (self.power + v.noise2 / v.motion) if v.motion > 0 else np.zeros_like(self.power)

    def learn(self, v: Variances) -> tuple[Variances, Solution]:
        """Learn the variances from `v` on; the solution there."""
        for _ in range(MAX_LEARNING_STEPS):
            found = self.solve(v)
            last, v = v, found.variances
            changes = [
                abs(now / max(before, 1e-12) - 1)
                for now, before in zip(astuple(v), astuple(last), strict=True)
            ]
            if max(changes[0], *changes[2:], changes[1] * (v.motion > 0)) < LEARNING_TOLERANCE:
                break
        return v, self.solve(v)

    def _improved(
        self, v: Variances, x: Array, u: Array, basis: Array, belief: Array, weights: Array
    ) -> Variances:
        """One step of the maximization: variances from the posterior's second moments."""
        size, free = self.size, len(self.gradient)
        covariance = v.noise2 * basis @ basis.T
        one = np.append(x, 1.0)
        rest = float(one @ self.total @ one) + float(np.sum(u * (2 * (one @ self.rows) + self.power * u)))
        across = self.rows[:, :size].transpose(0, 2, 1)  # (c, MOTION_SIZE, g)
        variance = v.noise2 * weights + weights**2 * np.einsum("cmg,gh,cmh->cm", across, covariance, across)
        known = dot(covariance, belief) + (float(variance.sum()) / v.motion if v.motion > 0 else u.size)
        freedom = self.count - (size + u.size - known)
        found = replace(v, noise2=max(rest / max(freedom, 0.1 * self.count, 1.0), self.floor))
        if v.motion > 0:
            square = float((u**2).sum() + variance.sum()) + MOTION_FREEDOM * self.expected_motion
            found = replace(found, motion=square / (u.size + MOTION_FREEDOM))
        second = (self.shape + x[free:]) ** 2 + np.diagonal(covariance)[free:]

        def deviation(part: Array, expected: float) -> float:
            return float(np.sqrt((part.sum() + SHAPE_FREEDOM * expected**2) / (len(part) + SHAPE_FREEDOM)))

        return replace(
            found,
            height=deviation(second[:BEND_SIZE], EXPECTED_HEIGHT),
            stretch=deviation(second[BEND_SIZE:], EXPECTED_STRETCH),
        )


def trusted_motion(v: Variances, noise2: float) -> float:
    """Variance of motion that counts, of residuals of variance `noise2` (px^2).

    The likelihood takes every misfit of the lens for motion in the directions that move the corners least. So
    more than a hand's counts only if motion explains most of the residuals: from a half on, in full from two
    thirds on.
    """
    share = 1 - v.noise2 / noise2
    trust = min(max(share / max(1 - share, 1e-12) - 1, 0.0), 1.0)
    usual = min(v.motion, FIRST_MOTION)
    return usual + trust * (v.motion - usual)


def marginal_information(information: Array, size: int) -> Array:
    """Information (size, size) of the first unknowns of (g, g), the others marginalised."""
    kept, across = information[:size, :size], information[:size, size:]
    out: Array = kept - across @ symmetric_inverse(information[size:, size:]) @ across.T
    return (out + out.T) / 2
