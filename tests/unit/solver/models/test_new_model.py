"""A new model is one class and one line in the registry."""

import numpy as np
import pytest

from calibsolver import Board, Camera, fit, models
from calibsolver.arrays import Array
from calibsolver.models import Coefficient, Model, Prior
from calibsolver.quality.model_selection import simplicity_rank
from tests.bench.bench_solver import spread
from tests.helpers.solver import synthetic


class Division(Model):
    """Fitzgibbon 2001: the ray of (u, v) is (u, v, 1 + k r^2); one coefficient."""

    name = "division"
    coefficients = ("k",)
    prior = Prior(focal=0.8, focal_sigma=0.5, distortion=(Coefficient(0.5, 1, 0.4),))
    start_focals = (0.35, 0.5, 0.7, 0.95, 1.3, 1.9, 2.8)

    def distort(self, d: Array, p: Array) -> Array:
        return 2 * p[:2] / (p[2] + np.sqrt(p[2] ** 2 - 4 * d[0] * (p[0] ** 2 + p[1] ** 2)))

    def distort_jacobian(self, d: Array, p: Array) -> tuple[Array, Array, Array]:
        rr = p[0] ** 2 + p[1] ** 2
        q = np.sqrt(p[2] ** 2 - 4 * d[0] * rr)
        u = 2 * p[:2] / (p[2] + q)
        by = np.stack([-4 * d[0] * p[0] / q, -4 * d[0] * p[1] / q, 1 + p[2] / q])  # d(z + q)/dp
        by_p = -u * by[:, None] / (p[2] + q)
        by_p[0, 0] += 2 / (p[2] + q)
        by_p[1, 1] += 2 / (p[2] + q)
        return u, (u * 2 * rr / q / (p[2] + q))[None], by_p

    def undistort(self, d: Array, u: Array) -> Array:
        v = np.stack([*u, 1 + d[0] * (u[0] ** 2 + u[1] ** 2)])
        v = np.where(v[2] > np.cos(self.domain_half_angle(d)) * np.linalg.norm(v, axis=0), v, np.nan)
        return v / np.linalg.norm(v, axis=0)

    def domain_half_angle(self, d: Array) -> float:
        return float(np.arctan2(1, 2 * np.sqrt(d[0])) if d[0] > 0 else 0.99 * np.pi)


def test_a_fifth_model_is_a_class_and_a_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(models.REGISTRY, "division", Division())
    truth = Camera.from_intrinsics("division", np.array([700, 702, 641, 355, -0.21]), (1280, 720))
    views = spread(Board(), truth, 8, np.random.default_rng(3))
    found = fit(views, truth.img_size, "division")
    assert found.avg_reprojection_error == pytest.approx(0.2 * np.sqrt(2), rel=0.1)
    np.testing.assert_array_less(
        np.abs(found.camera.intrinsics - truth.intrinsics), 4 * np.sqrt(np.diag(found.covariance))
    )
    assert synthetic.projection_error(truth, found.camera).mean() < 3 * found.uncertainty().rms
    assert [simplicity_rank(name) for name in (*models.NAMES, "division")][-1] == len(models.NAMES)
