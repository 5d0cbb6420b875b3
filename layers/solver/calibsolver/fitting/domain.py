"""Domain of the model over the whole image, as a prior.

A polynomial may fold just outside the corners, where nothing holds it. So where the fitted domain ends inside
the image, a one-sided prior pulls its edge out of the image. It is believed only if the points contradict it
by no more than chance: some lenses draw an image that ends, and some models cannot follow a lens.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array, Mask, symmetric_inverse
from ..camera import Camera
from ..models import Model
from . import outliers
from .levenberg_marquardt import Options, Problem, State

if TYPE_CHECKING:
    from .calibration import Calibration

MARGIN, SIGMA = 0.03, 0.02
"""Logarithm of the domain's image radius / distance of the farthest corner: the least, and its deviation."""
EDGE = 0.99
"""Share of the domain's half angle at which its image is measured: at the very edge it may be a pole."""
MAX_PREDICTED = 3000.0
"""Predicted increase of the squared residuals, in squares of the noise, above which the prior is not tried.
It is of first order, and the valley bends: the true increase may be a thousandth."""
MAX_INCREASE = 9.0
"""Increase up to which the points do not contradict the prior."""
MIN_COVERED = 0.9999
TOWARDS = Options(iterations=120, damping=1e-3)
DIFFERENCE = 1e-6
"""Relative step of derivatives."""


def excess(model: Model, k: Array, img_size: tuple[int, int]) -> float:
    """Logarithm of the farthest corner's distance / the domain's image radius, with the margin."""
    w, h = img_size
    angle = EDGE * min(model.domain_half_angle(k[4:]), np.pi)
    side = np.array([1.0, 0.0, -1.0, 0.0])
    rays = np.stack([np.sin(angle) * side, np.sin(angle) * np.roll(side, 1), np.full(4, np.cos(angle))])
    with np.errstate(all="ignore"):
        edge = np.hypot(*model.distort(k[4:], rays)).min()
        x, y = np.meshgrid(
            (np.array([-0.5, w - 0.5]) - k[2]) / k[0], (np.array([-0.5, h - 0.5]) - k[3]) / k[1]
        )
        found = float(np.log(np.hypot(x, y).max() / edge)) + MARGIN
    return found if np.isfinite(found) else 0.0


def gradient(model: Model, k: Array, img_size: tuple[int, int]) -> Array:
    """Derivatives (p,) of `excess`."""
    here, out = excess(model, k, img_size), np.empty(len(k))
    for i, value in enumerate(k):
        moved, step = k.copy(), DIFFERENCE * max(abs(float(value)), 1e-2)
        moved[i] += step
        out[i] = (excess(model, moved, img_size) - here) / step
    return out


@dataclass(frozen=True, eq=False)
class CoveringProblem(Problem):
    """A problem with the prior that the domain covers the image."""

    def prior(self, k: Array) -> tuple[Array, Array]:
        """Residuals and Jacobian of the prior, with one more if the domain does not cover the image."""
        r, j = super().prior(k)
        over = excess(self.model, k, self.img_size)
        if not over > 0:
            return r, j
        slope = gradient(self.model, k, self.img_size) / SIGMA
        slope = slope if self.basis is None else slope @ self.basis
        return np.append(r, over / SIGMA), np.concatenate([j, slope[None]])


def covering(
    problem: Problem, state: State, good: Mask, found: "Calibration"
) -> tuple[CoveringProblem, State] | None:
    """Return the problem with the prior and its optimum for the good points (v, n).

    None if the domain of the optimum `state` covers the image, or if the points contradict that it does.
    """
    model, k, size = problem.model, state.k, problem.img_size
    over = excess(model, k, size)
    if not over > 0 or found.camera.domain().covered >= MIN_COVERED:
        return None
    basis = np.eye(len(k)) if problem.basis is None else problem.basis
    along = gradient(model, k, size) @ basis
    variance = float(along @ symmetric_inverse(basis.T @ found.information @ basis) @ along)
    if not over**2 < MAX_PREDICTED * variance:
        return None
    wider = CoveringProblem(model, problem.obs, size, problem.basis, problem.origin)
    moved = wider.solve(wider.at(k, state.poses), outliers.unit_weights(good), TOWARDS)
    increase = float((moved.square - state.square)[good].sum())
    if not (moved.converged and increase <= MAX_INCREASE * found.noise**2):
        return None
    camera = Camera.from_intrinsics(model.name, moved.k, size)
    return (wider, moved) if camera.domain().covered >= MIN_COVERED else None
