"""Properties of every model at any plausible intrinsics."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calibsolver import Camera, models
from calibsolver.arrays import Array
from calibsolver.fitting import prior
from tests.conftest import THOROUGH

SIZE = (1280, 720)
SPREAD = {
    "rectilinear": ([-0.35, -0.05, -2e-3, -2e-3, -0.02], [0.15, 0.15, 2e-3, 2e-3, 0.02]),
    "fisheye": ([-0.06, -0.01, -4e-3, -5e-4], [0.06, 0.01, 4e-3, 5e-4]),
    "rational": (
        [-0.3, -0.1, -2e-3, -2e-3, -0.01, -0.05, 0.0, 0.0],
        [0.9, 0.2, 2e-3, 2e-3, 0.02, 1.2, 0.4, 0.06],
    ),
    "omnidirectional": ([0.0, -0.3, -0.02, -2e-3, -2e-3], [3.5, 0.2, 0.1, 2e-3, 2e-3]),
}
WIDEST = {True: np.radians(80), False: np.radians(125)}
seeds = st.integers(0, 2**32 - 1)
budget = settings(max_examples=40 if THOROUGH else 15)


def drawn(name: str, seed: int, count: int = 60) -> tuple[Camera, Array]:
    """A camera of the model, and points (n, 3) anywhere in its valid domain but its outermost 2 %."""
    rng = np.random.default_rng(seed)
    focal = rng.uniform(250, 1600)
    k = np.concatenate(
        [[focal, focal * rng.uniform(0.98, 1.02)], np.array([639.5, 359.5]) + rng.uniform(-30, 30, 2)]
    )
    camera = Camera.from_intrinsics(name, np.concatenate([k, rng.uniform(*SPREAD[name])]), SIZE)
    angle = (
        0.98
        * min(camera.domain().angle, WIDEST[models.get(name).is_perspective])
        * np.sqrt(rng.uniform(size=count))
    )
    azimuth = rng.uniform(0, 2 * np.pi, count)
    v = np.stack([np.sin(angle) * np.cos(azimuth), np.sin(angle) * np.sin(azimuth), np.cos(angle)], axis=1)
    points: Array = v * rng.uniform(0.5, 20, (count, 1))
    return camera, points


def derivative(function: Callable[[float], Array], step: float) -> Array:
    """Derivative at 0, by values at two steps to either side."""
    near, far = (function(step * n) - function(-step * n) for n in (1, 2))
    return (8 * near - far) / (12 * step)


@pytest.mark.parametrize("name", models.NAMES)
@given(seed=seeds)
@budget
def test_jacobians_equal_finite_differences(name: str, seed: int) -> None:
    camera, points = drawn(name, seed)
    model, k, p = models.get(name), camera.intrinsics, points.T
    q, by_k, by_p = model.jacobian(k, p)
    np.testing.assert_allclose(q, model.project(k, p), rtol=1e-13, atol=1e-11)

    def difference(by_axis: Array, by_point: Array, step: float) -> Array:
        """Derivative of the projection while both intrinsics and points move."""
        return derivative(lambda h: model.project(k + h * by_axis, p + h * by_point), step)

    for i, axis in enumerate(np.eye(model.size)):
        numeric = difference(axis, np.zeros_like(p), 3e-4 * max(abs(k[i]), 0.01))
        scale = np.abs(numeric).max() + 1e-9
        np.testing.assert_allclose(by_k[i] / scale, numeric / scale, atol=1e-6)
    # A point may lie close to the edge, where the picture bends within little: small steps.
    length = np.linalg.norm(p, axis=0)
    axes = [length * axis[:, None] for axis in np.eye(3)]
    numeric = np.stack([difference(np.zeros_like(k), axis, 2e-4) for axis in axes])
    scale = np.abs(numeric).max(axis=(0, 1))
    np.testing.assert_allclose(by_p * length / scale, numeric / scale, atol=1e-6)


@pytest.mark.parametrize("name", models.NAMES)
@given(seed=seeds)
@budget
def test_round_trips_within_the_domain(name: str, seed: int) -> None:
    camera, points = drawn(name, seed)
    rays = camera.unproject(camera.project(points))
    unit = points / np.linalg.norm(points, axis=1, keepdims=True)
    # Where a pixel covers much of the sphere, next to the edge, its rounding does too.
    np.testing.assert_allclose(rays, unit, atol=1e-8)


@pytest.mark.parametrize("name", models.NAMES)
@given(seed=seeds)
@budget
def test_no_pixel_gets_a_wrong_ray(name: str, seed: int) -> None:
    camera, _ = drawn(name, seed)
    rng = np.random.default_rng(seed)
    q = rng.uniform(-1, 2, (400, 2)) * SIZE
    rays = camera.unproject(q)
    seen = np.isfinite(rays[:, 0])
    np.testing.assert_allclose(np.linalg.norm(rays[seen], axis=1), 1, atol=1e-12)
    np.testing.assert_allclose(camera.project(rays[seen]), q[seen], atol=1e-9)
    domain = camera.domain()
    assert (np.arccos(np.clip(rays[seen, 2], -1, 1)) <= domain.angle + 1e-9).all()
    assert 0 < domain.covered <= 1


@pytest.mark.parametrize("name", models.NAMES)
@given(seed=seeds)
@budget
def test_prior_jacobian_equals_finite_differences(name: str, seed: int) -> None:
    model, k = models.get(name), drawn(name, seed)[0].intrinsics
    _, j = prior.residuals(model, k, SIZE)
    for i, axis in enumerate(np.eye(model.size)):
        # As small as rounding allows: at a stretch of 1, where its logarithm begins, the slope has a bend.
        step = 1e-5 * max(abs(k[i]), 0.01)
        numeric = derivative(lambda h, axis=axis: prior.residuals(model, k + h * axis, SIZE)[0], step)
        np.testing.assert_allclose(j[:, i], numeric, atol=1e-6 * np.abs(numeric).max())


@given(seed=seeds)
@budget
def test_radial_derivative_equals_finite_differences(seed: int) -> None:
    camera, points = drawn("rational", seed)
    model, d = models.get("rational"), np.array(camera.distortion)
    d[2:4] = 0
    r = np.linalg.norm(points[:, :2], axis=1) / points[:, 2]
    numeric = derivative(lambda h: model.distort(d, np.stack([r + h, 0 * r, 0 * r + 1]))[0], 1e-4)
    value, _, _ = model.radial_derivative(d, r**2) or (r, r, r)
    np.testing.assert_allclose(value, numeric, atol=1e-6)
