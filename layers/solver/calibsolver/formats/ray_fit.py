"""Ray fit: the camera of another model whose projections of an image's rays are closest to their pixels.

In the frame of that camera: a turn, which a fit to keypoints is free to make, would be a shift of all that is
seen, and in a rig would contradict the poses of the cameras.
"""

import numpy as np

from .. import models
from ..arrays import Array
from ..camera import Camera
from ..errors import CalibrationError
from ..fitting.levenberg_marquardt import Options, Problem, State
from ..fitting.normal_equations import POSE_SIZE, Poses
from ..fitting.observations import Observations
from ..models import Model
from .base import ModelConstraint

SAMPLE_GRID = (33, 25)
"""Columns and rows of the pixels at which cameras are fitted to each other, the image's edge among them."""
MAX_FOLLOWED = 3
OPTIONS = Options(with_prior=False, iterations=100, tolerance=1e-5, damping=1e-6)
"""Of one fit: valleys of denominators are long."""


def sample_pixels(img_size: tuple[int, int]) -> Array:
    """Return pixels (2, n) all over an image."""
    w, h = img_size
    x, y = np.meshgrid(np.linspace(0, w - 1, SAMPLE_GRID[0]), np.linspace(0, h - 1, SAMPLE_GRID[1]))
    return np.stack([x.ravel(), y.ravel()])


def sampled_rays(camera: Camera, max_angle: float = np.pi) -> tuple[Array, Array]:
    """Return unit rays (3, n) of pixels all over an image, and the pixels (2, n), up to an angle in radians.

    Raises CalibrationError ``not_representable`` if there are none.
    """
    q = sample_pixels(camera.img_size)
    rays = models.get(camera.model).unproject(camera.intrinsics, q)
    visible = rays[2] > np.cos(max_angle)  # also false where there is no ray
    if visible.sum() < models.get(camera.model).size:
        raise CalibrationError("not_representable", "the camera has no rays")
    return rays[:, visible], q[:, visible]


def fit_to_rays(camera: Camera, constraint: ModelConstraint) -> Camera:
    """Fit the camera of a constraint that draws the picture most alike, by least squares over the image.

    Raises as `fit_samples` does.
    """
    rays, q = sampled_rays(camera, models.get(constraint.model).max_angle)
    return fit_samples(rays, q, camera.img_size, constraint, camera)


def fit_samples(
    rays: Array, q: Array, img_size: tuple[int, int], constraint: ModelConstraint, near: Camera | None = None
) -> Camera:
    """Fit the camera of a constraint to unit rays (3, n) and their pixels (2, n); `near` may be near.

    Raises CalibrationError ``not_representable`` if the fit diverges.
    """
    model = models.get(constraint.model)
    observations = Observations(rays[None], q[None], np.ones((1, q.shape[1]), dtype=bool))
    basis = free_directions(model, constraint)
    problem = _RayProblem(model, observations, img_size, basis)
    own = near is not None and near.model == model.name
    starts = [near.intrinsics] if near is not None and own else _starts(model, img_size, rays, q)
    with np.errstate(all="ignore"):  # a step too far is tested before it is taken
        fits = [_descend(problem, basis @ np.linalg.lstsq(basis, k, rcond=None)[0]) for k in starts]
    square, k = min(fits, key=lambda one: one[0], default=(np.inf, np.zeros(model.size)))
    if not np.isfinite(square):
        raise CalibrationError("not_representable", "the fit of the simpler model diverged")
    return Camera.from_intrinsics(model.name, k, img_size)


def free_directions(model: Model, constraint: ModelConstraint) -> Array:
    """T (p, a): fx fy cx cy and the coefficients that a constraint leaves free; intrinsics are T a."""
    names = ("fx", "fy", "cx", "cy", *model.coefficients)
    free = np.eye(model.size)[:, [name not in constraint.zero for name in names]]
    if constraint.equal_focal:
        free = np.delete(free, 1, axis=1)
        free[1, 0] = 1
    return free


def _starts(model: Model, img_size: tuple[int, int], rays: Array, q: Array) -> list[Array]:
    """Return the best intrinsics (p,) with each of the model's initial coefficients; focal lengths follow."""
    starts = []
    initial = [model.start(1.0, img_size), *model.initial_intrinsics(img_size)]
    for d in {tuple(k[4:].tolist()) for k in initial}:
        with np.errstate(all="ignore"):
            u = model.distort(np.array(d), rays)
        if not np.isfinite(u).all():
            continue
        lines = [np.polyfit(u[axis], q[axis], 1) for axis in (0, 1)]
        k = np.array([lines[0][0], lines[1][0], lines[0][1], lines[1][1], *d])
        starts.append((float(np.square(model.project(k, rays) - q).sum()), k))
    return [k for _, k in sorted(starts, key=lambda one: one[0])[:MAX_FOLLOWED]]


class _RayProblem(Problem):
    """Rays in the frame of the camera itself: the pose is held."""

    def at(self, k: Array, poses: Poses) -> State:
        state = super().at(k, poses)
        state.rows[-1 - POSE_SIZE : -1] = 0
        return state


def _descend(problem: Problem, k: Array) -> tuple[float, Array]:
    """Return the sum of squares and the intrinsics (p,) at the optimum near k."""
    at_rest = Poses.of_vectors(np.zeros((1, POSE_SIZE)))
    state = problem.solve(problem.at(k, at_rest), problem.obs.mask.astype(float), OPTIONS)
    return float(state.square.sum()), state.k
