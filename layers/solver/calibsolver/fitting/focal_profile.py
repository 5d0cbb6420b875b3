"""Focal profile: the cost that each focal length leaves, and other cameras that explain the views as well.

If a model does not quite describe a lens and the views are tilted alike, distortion and principal point can
stand in for the focal length. The profile then has two minima, and a second calibration may end in the other
one, farther away than the curvature of either predicts. (Bates & Watts 1988, chapter 6.)
"""

from dataclasses import replace

import numpy as np

from ..arrays import Array, Mask, frozen, symmetric_inverse
from . import plausibility, prior
from .calibration import Calibration
from .levenberg_marquardt import Options, Problem, State
from .normal_equations import Poses

STEP = float(np.log(2)) / 2
"""Logarithm of the focal length, half an octave to either side, at which it is held."""
MAX_STEP_DEVIATIONS = 10.0
"""Largest `STEP` / standard deviation of the logarithm.

Beyond, the views determine the focal length, and the profile has one minimum.
"""
HELD = Options(robust=True, tolerance=1e-2, damping=1e-6, one_step=True)
ALONG_VALLEY = Options(tolerance=1e-5, damping=1e-5, one_step=True, patient=True)
MIN_DETERMINING_VIEWS = 3
"""Views that determine all intrinsics (Zhang 2000): with fewer the prior decides."""


def covariance_of_optima(problem: Problem, state: State, good: Mask, found: Calibration) -> Array:
    """Covariance (p, p) of the intrinsics with the other optima of the profile, by their likelihood.

    It is that of the calibration `found` if there is no other, or none is expected. `good` (v, n) are the
    points that took part.
    """
    covariance = np.asarray(found.covariance)
    gradient = log_focal_gradient(problem, state)
    deviation = float(np.sqrt(gradient @ covariance @ gradient))
    if good.any(axis=1).sum() < MIN_DETERMINING_VIEWS or MAX_STEP_DEVIATIONS * deviation < STEP:
        return covariance
    # The errors that views share count in the likelihood as in the error bars.
    free = problem.directions
    information, along = free.T @ found.information @ free, gradient @ free
    white = along @ symmetric_inverse(information) @ along
    variance = found.noise**2 * max(deviation**2 / float(white), 1.0)
    moments = covariance.copy()
    for step in (-STEP, STEP):
        other = optimum_beside(problem, state, good, step)
        if abs(gradient @ (other.k - state.k)) < deviation / 2:
            continue  # the same optimum
        other = problem.solve(other, good, Options())
        change = other.k - state.k
        # Another calibration might return a fit that ends there.
        is_taken = other.converged and other.is_finite and not plausibility.folds(problem, other, good)
        # Within a deviation it is the same optimum, or one that does not matter.
        if is_taken and abs(gradient @ change) > deviation:
            # Never more than equally likely: the prior, too weak to decide, favours the optimum of the fit.
            excess = max(float((other.square[good] - state.square[good]).sum()) / variance, 0.0)
            likelihood_ratio = np.exp(-excess / 2)
            moments += np.outer(change, change) * likelihood_ratio / (1 + likelihood_ratio)
    return frozen(moments)


def optimum_beside(problem: Problem, state: State, good: Mask, step: float) -> State:
    """Fit the good points (v, n), approximately, from where the log focal length was held a step away."""
    factor = float(np.exp(step))
    k = state.k.copy()
    k[:2] *= factor
    k = problem.nearest(k)
    poses = Poses(state.poses.r, state.poses.t * (1, 1, factor))  # of the same size in the image
    # All directions but the one in which the focal length grows.
    free = problem.directions
    basis = np.linalg.svd((log_focal_gradient(problem, state) @ free)[None])[2][1:].T
    held = replace(problem, basis=free @ basis)
    best = held.solve(held.at(k, poses), good, HELD)
    return problem.solve(problem.at(best.k, best.poses), good, ALONG_VALLEY)


def log_focal_gradient(problem: Problem, state: State) -> Array:
    """Gradient (p,) of the logarithm of the focal length: the first residual of the prior, whitened."""
    by_k = prior.residuals(problem.model, state.k, problem.img_size)[1]
    gradient: Array = by_k[0] * problem.model.prior.focal_sigma
    return gradient
