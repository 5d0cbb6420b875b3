"""Lower bound of any guidance: views chosen with the true camera known, and all of them together."""

import numpy as np

from calibsolver import Board, Camera
from calibsolver.arrays import symmetric_inverse
from calibsolver.fitting import prior
from calibsolver.guidance import IntrinsicsPosterior, ProjectionUncertainty
from calibsolver.guidance.candidates import PoseLimits

SWEEPS = 2


def bound(camera: Camera, counts: tuple[int, ...], noise: float = 0.2) -> list[float]:
    """Predicted rms error over the image, px, of the best `counts` views found: greedy, then exchanged."""
    board = Board()
    guide = ProjectionUncertainty(board, camera.img_size, camera.model)
    model, k = guide.model, camera.intrinsics
    nothing = IntrinsicsPosterior(
        model, k, prior.information(model, k, camera.img_size), noise, camera.img_size
    )
    found: list[np.ndarray] = []
    out = []
    for count in counts:
        while len(found) < count:
            found.append(best(guide, nothing, found, len(found)))
        for sweep in range(SWEEPS):
            for i in range(count):
                others = found[:i] + found[i + 1 :]
                other = best(guide, nothing, others, count + sweep)
                if error(nothing, [*others, other]) < error(nothing, found):
                    found[i] = other
        out.append(error(nothing, found))
    return out


def best(
    guide: ProjectionUncertainty, nothing: IntrinsicsPosterior, found: list[np.ndarray], index: int
) -> np.ndarray:
    """Information (p, p) of the pose that is found best beside others."""
    information = nothing.information + sum(found, np.zeros_like(nothing.information))
    posterior = IntrinsicsPosterior(nothing.model, nothing.k, information, nothing.noise, nothing.img_size)
    with np.errstate(all="ignore"):
        target = guide.choose(posterior, index, PoseLimits())
    after = guide.predict_posterior(posterior, target).information
    gained: np.ndarray = after - information
    return gained


def error(nothing: IntrinsicsPosterior, found: list[np.ndarray]) -> float:
    covariance = symmetric_inverse(nothing.information + sum(found, np.zeros_like(nothing.information)))
    return float(np.sqrt(np.sum(covariance * nothing.error_metric)))
