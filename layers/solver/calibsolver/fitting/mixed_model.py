"""Mixed model of the views: what they share, and what differs between them, with learnt variances.

Linearized, the residuals of a cluster of views are e + A x + Z u + noise. All views share x: the shape of the
board and the intrinsics. Each cluster has its own u: the motion of the hand during the readout
(`systematic_effects`). Shape and motion are random effects (Laird & Ware 1982). Their variances and that of
the noise are learnt by expectation maximization of the restricted likelihood (Patterson & Thompson 1971;
Dempster, Laird & Rubin 1977), with weak priors. So a flat board and a still hand cost next to nothing.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array, dot, symmetric_inverse
from .effect_variances import trust
from .normal_equations import solve_or_nan
from .systematic_effects import BEND_SIZE, EFFECTS_SIZE

SHAPE_SIZE = 5
"""Numbers of the board's shape: height by x^2, xy and y^2; stretch of x against y; shear."""
MOTION_SIZE = EFFECTS_SIZE - BEND_SIZE
EXPECTED_HEIGHT, EXPECTED_STRETCH, SHAPE_FREEDOM = 2e-4, 1e-4, 1.0
"""Prior of the standard deviations of heights / board and of stretch, and its degrees of freedom."""
FIRST_HEIGHT, FIRST_STRETCH = 3e-3, 1.5e-3
"""Initial standard deviations, of boards of paper."""
MAX_STRETCH_DEVIATION = 2.5e-3
"""Largest standard deviation of stretch, of prints that differ by half a percent across and down."""
EXPECTED_MOTION, MOTION_FREEDOM = 0.008, 1.0
"""Prior of the variance of motion / that of a hand, for usual corners, and its degrees of freedom."""
FIRST_MOTION = 1.0
"""Initial variance of motion: the maximization is slow from below."""
MAX_LEARNING_STEPS, LEARNING_TOLERANCE = 60, 1e-2
EXTRAPOLATION_STEPS = 3
MAX_RATE = 0.95


@dataclass(frozen=True)
class Variances:
    """Variances of noise (px^2) and motion; standard deviations of the shape's heights and of its stretch."""

    noise2: float
    motion: float = FIRST_MOTION
    height: float = FIRST_HEIGHT
    stretch: float = FIRST_STRETCH

    def shape_deviations(self) -> Array:
        """(SHAPE_SIZE,) standard deviations."""
        return np.array([self.height] * BEND_SIZE + [self.stretch] * (SHAPE_SIZE - BEND_SIZE))

    def logarithms(self) -> list[float]:
        """Logarithms of all four."""
        return [math.log(each) for each in (self.noise2, max(self.motion, 1e-12), self.height, self.stretch)]


@dataclass(frozen=True, eq=False)
class Solution:
    """Step `one` (g + 1,) of x, then 1; variances of motion given the rest (c MOTION_SIZE,), at unit noise.

    Also the variances after one more step of the maximization.
    """

    one: Array
    weights: Array
    variances: Variances


class MixedModel:
    """One linearization of the views.

    Parameters
    ----------
    gram
        (c, g + MOTION_SIZE + 1, ...) Gram matrices of each cluster: x, motion, residuals, px^2; the poses
        projected out.
    count
        Number of residuals less the unknowns of the poses.
    prior
        Information (p, p) of the intrinsics' prior and half its gradient (p,); they come last in x.
    shape
        (SHAPE_SIZE,) shape so far, the first of x.
    floor
        Least variance of the noise, px^2.
    expected_motion
        Prior of the variance of motion.
    max_stretch
        Largest standard deviation of stretch.
    """

    def __init__(
        self,
        gram: Array,
        count: int,
        prior: tuple[Array, Array],
        shape: Array,
        floor: float,
        expected_motion: float,
        max_stretch: float,
    ) -> None:
        self.floor = floor
        self.max_stretch = max_stretch
        self.expected_motion = expected_motion
        self.size = size = gram.shape[1] - MOTION_SIZE - 1
        kept = [*range(size), size + MOTION_SIZE]
        moves = slice(size, size + MOTION_SIZE)
        self.count = count
        self.shape = shape
        # Information and half gradient of the priors of camera, heights and stretch, at unit variances.
        self.beliefs = np.zeros((3, size + 1, size + 1))
        self.beliefs[0, SHAPE_SIZE:-1, SHAPE_SIZE:-1], self.beliefs[0, SHAPE_SIZE:-1, -1] = prior
        for i, number in enumerate(shape):
            part = self.beliefs[1 if i < BEND_SIZE else 2]
            part[i, i], part[i, -1] = 1, number
        self.gram = gram
        self.total = gram.sum(axis=0)[kept][:, kept]
        scale = 1 / np.sqrt(np.maximum(self.total.diagonal()[:-1], 1e-300))
        self.scale = scale[:, None] * scale
        # In the principal directions of each cluster's motion its covariance is diagonal.
        power, self.directions = np.linalg.eigh(gram[:, moves, moves])
        self.power = np.maximum(power.ravel(), 0.0)
        self.rows = gram[:, :, moves] @ self.directions
        self.across = self.rows.transpose(1, 0, 2)[kept].reshape(size + 1, -1)

    @property
    def noise2(self) -> float:
        """Variance of the residuals, px^2, with motion."""
        freedom = max(self.count - self.size, 0.1 * self.count, 1.0)
        variance: float = max(float(self.total[-1, -1]) / freedom, self.floor)
        return variance

    def solve(self, v: Variances) -> Solution:
        """Solve at the variances `v`, motion marginalised."""
        weights = self._weights(v)
        pull = self.across * weights
        left, belief = self.total - pull @ self.across.T, self._belief(v)
        total = left + belief
        inverse = self._inverse(total[:-1, :-1])
        one = np.ones(self.size + 1)
        x = np.matmul(inverse, -total[:-1, -1], out=one[:-1])
        # One step of the maximization, from the second moments of the posterior.
        rest, known, motion = dot(one @ left, one), dot(inverse, belief[:-1, :-1]), v.motion
        if motion > 0:
            pulls = pull @ pull.T
            moved = dot(one @ pulls, one)
            variance = v.noise2 * (float(weights.sum()) + dot(inverse, pulls[:-1, :-1]))
            rest -= v.noise2 / motion * moved
            known += variance / motion
            square = moved + variance + MOTION_FREEDOM * self.expected_motion
            motion = square / (weights.size + MOTION_FREEDOM)
        else:
            known += weights.size
        freedom = self.count - (self.size + weights.size - known)
        noise2 = max(rest / max(freedom, 0.1 * self.count, 1.0), self.floor)
        spread = v.noise2 * inverse.diagonal()[:SHAPE_SIZE]
        second = ((self.shape + x[:SHAPE_SIZE]) ** 2 + spread).tolist()
        height = deviation(second[:BEND_SIZE], EXPECTED_HEIGHT)
        stretch = min(deviation(second[BEND_SIZE:], EXPECTED_STRETCH), self.max_stretch)
        return Solution(one, weights, Variances(noise2, motion, height, stretch))

    def shape_gain(self, v: Variances) -> float:
        """Decrease of the cost by the shape, in squares of the noise, given motion (Wald's statistic)."""
        total = self.total - (self.across * self._weights(v)) @ self.across.T + self._belief(v)
        inverse = self._inverse(total[:-1, :-1])
        x = inverse[:SHAPE_SIZE] @ total[:-1, -1]
        return dot(x, solve_or_nan(inverse[:SHAPE_SIZE, :SHAPE_SIZE], x)) / v.noise2

    def learn(self, v: Variances) -> Solution:
        """Learn the variances from `v` on, with the solution of the last step."""
        last = v.logarithms()
        previous = [0.0] * len(last)
        for step in range(MAX_LEARNING_STEPS):
            solution = self.solve(v)
            v = solution.variances
            now = v.logarithms()
            change = [a - b for a, b in zip(now, last, strict=True)]
            if not any(abs(each) > LEARNING_TOLERANCE for each in change):
                break
            if step % EXTRAPOLATION_STEPS == EXTRAPOLATION_STEPS - 1:
                now = [a + remainder(c, p) for a, c, p in zip(now, change, previous, strict=True)]
                noise2, motion, height, stretch = map(math.exp, now)
                v = Variances(max(noise2, self.floor), motion if v.motion > 0 else 0.0, height, stretch)
            last, previous = now, change
        return solution

    def motion(self, solution: Solution) -> Array:
        """Motion (c, MOTION_SIZE) of each cluster."""
        u = -(solution.one @ self.across) * solution.weights
        out: Array = np.einsum("cij,cj->ci", self.directions, u.reshape(-1, MOTION_SIZE))
        return out

    def information(self, v: Variances) -> Array:
        """Information (g, g) of the views without motion and of the priors, at unit noise."""
        out: Array = (self.total + self._belief(v))[:-1, :-1]
        return out

    def _belief(self, v: Variances) -> Array:
        """Information and half gradient (g + 1, g + 1) of the priors, at unit noise."""
        parts = np.array([v.noise2, v.noise2 / v.height**2, v.noise2 / v.stretch**2])
        return (parts @ self.beliefs.reshape(3, -1)).reshape(self.total.shape)

    def _inverse(self, a: Array) -> Array:
        """Inverse of A (g, g), as `symmetric_inverse`: faster, where A is well positive definite."""
        try:
            out: Array = np.asarray(np.linalg.inv(a * self.scale), dtype=np.float64)
        except np.linalg.LinAlgError:
            return symmetric_inverse(a)
        out *= self.scale
        return out if out.diagonal().min() > 0 else symmetric_inverse(a)

    def _weights(self, v: Variances) -> Array:
        return 1 / (self.power + v.noise2 / v.motion) if v.motion > 0 else np.zeros_like(self.power)


def deviation(second: Sequence[float], expected: float) -> float:
    """Standard deviation of numbers with these second moments, by its prior."""
    return math.sqrt((sum(second) + SHAPE_FREEDOM * expected**2) / (len(second) + SHAPE_FREEDOM))


def remainder(change: float, previous: float) -> float:
    """Sum of the changes after two successive ones of a geometric series."""
    rate = min(max(change / previous, 0.0), MAX_RATE) if previous else 0.0
    return change * rate / (1 - rate)


def trusted_motion(v: Variances, noise2: float) -> float:
    """Variance of motion that counts, of residuals of variance `noise2` (px^2).

    The likelihood takes misfit of the lens for motion. So more than a hand's counts only from half of the
    residuals explained on, in full from two thirds on.
    """
    usual = min(v.motion, FIRST_MOTION)
    return usual + trust(1 - v.noise2 / noise2) * (v.motion - usual)


def marginal_information(information: Array, size: int) -> Array:
    """Information (size, size) of the last unknowns of (g, g), the others marginalised."""
    kept, across = information[-size:, -size:], information[-size:, :-size]
    out: Array = kept - across @ symmetric_inverse(information[:-size, :-size]) @ across.T
    return (out + out.T) / 2
