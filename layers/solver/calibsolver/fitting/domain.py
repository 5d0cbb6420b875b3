"""Domain of the model over the whole image, as a prior.

A polynomial may fold just outside the corners. So if the fitted domain ends inside the image, a one-sided
prior pulls its edge out of the image. It counts only if the points contradict it by no more than chance: some
lenses draw an image that ends, and some models cannot follow a lens.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array, Mask, symmetric_inverse
from ..camera import Camera
from ..models import Model
from .levenberg_marquardt import Options, Problem, State

if TYPE_CHECKING:
    from .calibration import Calibration

MARGIN, SIGMA = 0.03, 0.02
"""Logarithm of the domain's image radius / distance of the farthest corner: the least, and its deviation."""
EDGE = 0.99
"""Share of the domain's half angle at which its image is measured: the edge itself may be a pole."""
MAX_PREDICTED = 3000.0
"""Predicted increase of the squared residuals, in squares of the noise, above which the prior is not
tried. The valley bends: the true increase may be a thousandth."""
MAX_INCREASE = 9.0
"""Increase up to which the points do not contradict the prior."""
MIN_COVERED = 0.9999
TOWARDS = Options(iterations=120, damping=1e-3)
SIDES = np.array([[1.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, -1.0]])
DIFFERENCE = 1e-6


def excess(model: Model, k: Array, img_size: tuple[int, int]) -> float:
    """Logarithm of the farthest corner's distance / the domain's image radius, with the margin."""
    over = log_corner(k, img_size) - log_edge(model, k) + MARGIN
    return over if math.isfinite(over) else 0.0


def log_corner(k: Array, img_size: tuple[int, int]) -> float:
    """Logarithm of the farthest corner's distance on the plane of unit focal length."""
    (w, h), (fx, fy, cx, cy) = img_size, k[:4].tolist()
    x = max(abs(-0.5 - cx), abs(w - 0.5 - cx)) / fx
    y = max(abs(-0.5 - cy), abs(h - 0.5 - cy)) / fy
    return math.log(math.hypot(x, y))


def log_edge(model: Model, k: Array) -> float:
    """Logarithm of the domain's image radius there; NaN if it has no edge."""
    angle = EDGE * min(model.domain_half_angle(k[4:]), np.pi)
    rays = np.stack([*(math.sin(angle) * SIDES), np.full(4, math.cos(angle))])
    with np.errstate(all="ignore"):
        x, y = model.distort(k[4:], rays)
        return float(np.log(np.hypot(x, y).min()))


def gradient(model: Model, k: Array, img_size: tuple[int, int]) -> Array:
    """Derivatives (p,) of `excess`."""
    corner, edge, out = log_corner(k, img_size), log_edge(model, k), np.empty(len(k))
    for i, value in enumerate(k):
        moved, step = k.copy(), DIFFERENCE * max(abs(float(value)), 1e-2)
        moved[i] += step
        change = log_corner(moved, img_size) - corner if i < 4 else edge - log_edge(model, moved)
        out[i] = change / step
    return out


@dataclass(frozen=True, eq=False)
class CoveringProblem(Problem):
    """A problem with the prior that the domain covers the image."""

    def prior(self, k: Array) -> tuple[Array, Array]:
        """Residuals and Jacobian, with one row more if the domain does not cover the image."""
        r, j = super().prior(k)
        over = excess(self.model, k, self.img_size)
        if not over > 0:
            return r, j
        slope = gradient(self.model, k, self.img_size) / SIGMA @ self.directions
        return np.append(r, over / SIGMA), np.concatenate([j, slope[None]])


def covering(
    problem: Problem, state: State, good: Mask, found: "Calibration"
) -> tuple[CoveringProblem, State] | None:
    """Problem with the prior and its optimum for the good points (v, n).

    None if the domain of the optimum `state` covers the image, or if the points contradict that it does.
    """
    model, k, size = problem.model, state.k, problem.img_size
    over = excess(model, k, size)
    if not over > 0:
        return None
    free = problem.directions
    along = gradient(model, k, size) @ free
    variance = float(along @ symmetric_inverse(free.T @ found.information @ free) @ along)
    if not over**2 < MAX_PREDICTED * variance or found.camera.domain().covered >= MIN_COVERED:
        return None
    wider = CoveringProblem(model, problem.obs, size, problem.basis, problem.origin)
    moved = wider.solve(wider.at(k, state.poses), good, TOWARDS)
    increase = float((moved.square - state.square)[good].sum())
    if not (moved.converged and increase <= MAX_INCREASE * found.noise**2):
        return None
    camera = Camera.from_intrinsics(model.name, moved.k, size)
    return (wider, moved) if camera.domain().covered >= MIN_COVERED else None
