"""Models against OpenCV and closed forms; a new model is one class and one line in the registry."""

import cv2
import numpy as np
import pytest

from calibsolver import Board, CalibrationError, Camera, fit, models
from calibsolver.arrays import Array
from calibsolver.models import Coefficient, Model, Prior
from calibsolver.quality.model_selection import simplicity_rank
from tests.bench.bench_solver import spread
from tests.helpers.solver import synthetic
from tests.helpers.solver.export_sources import truth

WIDEST = {"rectilinear": 50.0, "fisheye": 125.0, "rational": 62.0, "omnidirectional": 125.0}


def rays(name: str, count: int = 400) -> Array:
    """Points (3, n) at 0.5 to 20 units, up to the widest angle from the axis."""
    rng = np.random.default_rng(3)
    angle = np.radians(WIDEST[name]) * np.sqrt(rng.uniform(size=count))
    azimuth = rng.uniform(0, 2 * np.pi, count)
    v = np.stack([np.sin(angle) * np.cos(azimuth), np.sin(angle) * np.sin(azimuth), np.cos(angle)])
    scaled: Array = v * rng.uniform(0.5, 20, count)
    return scaled


@pytest.mark.parametrize("name", models.NAMES)
def test_jacobian_on_the_optical_axis_is_the_focal_length(name: str) -> None:
    camera = truth(name)
    model, k = models.get(name), camera.intrinsics
    q, by_k, by_p = model.jacobian(k, np.array([[0.0], [0.0], [2.0]]))
    np.testing.assert_allclose(q[:, 0], k[2:4], atol=1e-12)
    np.testing.assert_allclose(by_p[:2, :, 0], np.diag(camera.focal) / 2, atol=1e-9)
    assert np.isfinite(by_k).all()


@pytest.mark.parametrize("name", models.NAMES)
def test_points_are_valid_where_they_have_a_pixel(name: str) -> None:
    camera = truth(name)
    points = np.random.default_rng(1).normal(size=(200, 3))
    has_pixel = np.isfinite(camera.project(points)).all(axis=1)
    np.testing.assert_array_equal(camera.valid(points), has_pixel)
    assert 0 < has_pixel.mean() < 1


def opencv(name: str, p: Array, matrix: Array, d: Array) -> Array:
    zero = np.zeros((3, 1))
    if name == "fisheye":
        q = cv2.fisheye.projectPoints(p[:, None], zero, zero, matrix, d)[0]
    elif name == "omnidirectional":
        q = cv2.omnidir.projectPoints(p[:, None], zero, zero, matrix, d[0], d[1:][None])[0]
    else:
        q = cv2.projectPoints(p, zero, zero, matrix, d)[0]
    return np.asarray(q.reshape(-1, 2), dtype=np.float64)


@pytest.mark.parametrize("name", models.NAMES)
def test_projection_equals_opencv(name: str) -> None:
    p = rays(name)
    if name == "fisheye":
        p = p[:, p[2] > 0.1 * np.linalg.norm(p, axis=0)]
    assert (p[2] < -0.3 * np.linalg.norm(p, axis=0)).any() == (name == "omnidirectional")
    camera = truth(name)
    theirs = opencv(name, p.T, camera.matrix, camera.distortion)
    np.testing.assert_allclose(models.get(name).project(camera.intrinsics, p).T, theirs, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "distortion", "edge"),
    [
        ("rectilinear", [-0.4, 0.0, 0.0, 0.0, 0.0], np.arctan(np.sqrt(1 / 1.2))),
        ("fisheye", [-0.2, 0.0, 0.0, 0.0], np.sqrt(1 / 0.6)),
    ],
)
def test_fold_is_found_and_never_crossed(name: str, distortion: list[float], edge: float) -> None:
    """The closed-form angle is where the radial part stops growing."""
    camera = Camera(
        name, np.array([[500, 0, 640], [0, 500, 360], [0, 0, 1.0]]), np.array(distortion), (1280, 720)
    )

    def at(angle: float) -> Array:
        return np.array([[np.sin(angle), 0.0, np.cos(angle)]])

    inside, outside = camera.project(at(edge - 1e-6)), camera.project(at(edge + 1e-6))
    assert np.isfinite(inside).all()
    assert np.isnan(outside).all()
    beyond = camera.unproject(inside + np.array([1.0, 0.0]))
    assert np.isnan(beyond).all()
    back = camera.unproject(camera.project(at(edge - 0.05)))
    np.testing.assert_allclose(back, at(edge - 0.05), atol=1e-9)


def test_unknown_model_is_refused_by_name() -> None:
    with pytest.raises(CalibrationError, match="no camera model is called 'pinhole'") as caught:
        models.get("pinhole")
    assert caught.value.code == "unknown_model"


def test_camera_with_coefficients_of_another_model_is_refused() -> None:
    with pytest.raises(CalibrationError):
        Camera("rectilinear", np.eye(3), np.zeros(4), (1280, 720))


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
