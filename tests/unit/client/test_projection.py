"""Projection of the Python client, against OpenCV and against the solver."""

import cv2
import numpy as np
import pytest

from calibdb_client import UsageError
from calibdb_client.projection import Lens
from calibdb_client.rectification import new_camera_matrix, remap_tables
from calibsolver import Camera

SIZE = (1280, 720)
MATRIX = np.array([[950.0, 0, 652], [0, 948, 351], [0, 0, 1]])
WIDE = np.array([[420.0, 0, 652], [0, 418, 351], [0, 0, 1]])
LENSES = {
    "rectilinear": (MATRIX, [-0.32, 0.12, 0.0005, -0.0004, -0.02]),
    "fisheye": (WIDE, [0.02, -0.01, 0.004, -0.001]),
    "rational": (MATRIX, [0.5, -0.2, 0.0003, 0.0002, 0.01, 0.7, -0.1, 0.02]),
    "omnidirectional": (WIDE, [0.9, -0.05, 0.01, 0.0004, -0.0003]),
}


def pixels(step: int = 40) -> np.ndarray:
    u, v = np.meshgrid(np.arange(0, SIZE[0], step), np.arange(0, SIZE[1], step))
    return np.stack([u.ravel(), v.ravel()], axis=1).astype(float)


@pytest.mark.parametrize("model", LENSES)
def test_projection_equals_the_solvers(model: str) -> None:
    matrix, d = LENSES[model]
    lens, camera = Lens(model, matrix, d), Camera(model, matrix, np.array(d), SIZE)
    rng = np.random.default_rng(1)
    points = rng.normal(size=(5000, 3)) * [2, 2, 1] + [0, 0, 1]
    expected, found = camera.project(points), lens.project(points)
    inside = [((q >= 0) & (q < SIZE)).all(axis=1) for q in (expected, found)]
    assert np.array_equal(*inside)
    assert inside[0].sum() > 300
    assert np.abs(expected - found)[inside[0]].max() < 1e-8
    rays, expected_rays = lens.unproject(pixels()), camera.unproject(pixels())
    assert np.array_equal(np.isnan(rays), np.isnan(expected_rays))
    assert np.nanmax(np.abs(rays - expected_rays)) < 1e-9


@pytest.mark.parametrize("model", LENSES)
def test_unprojected_pixels_project_to_themselves(model: str) -> None:
    matrix, d = LENSES[model]
    lens = Lens(model, matrix, d)
    rays = lens.unproject(pixels())
    seen = np.isfinite(rays[:, 0])
    assert seen.mean() > 0.95
    assert np.abs(lens.project(3.7 * rays[seen]) - pixels()[seen]).max() < 1e-8
    assert np.abs(np.linalg.norm(rays[seen], axis=1) - 1).max() < 1e-12


@pytest.mark.parametrize("model", ["rectilinear", "rational", "fisheye"])
def test_remap_tables_equal_opencvs(model: str) -> None:
    matrix, d = LENSES[model]
    new = matrix * [[0.8], [0.8], [1]]
    found = remap_tables(Lens(model, matrix, d), new, SIZE)
    make = cv2.fisheye.initUndistortRectifyMap if model == "fisheye" else cv2.initUndistortRectifyMap
    expected = make(matrix, np.array(d), np.eye(3), new, SIZE, cv2.CV_32FC1)
    for one, other in zip(found, expected, strict=True):
        seen = one >= 0
        assert seen.mean() > 0.9
        assert np.abs(one - other)[seen].max() < 1e-2


@pytest.mark.parametrize("alpha", [0.0, 0.4, 1.0])
def test_new_camera_matrix_is_near_opencvs(alpha: float) -> None:
    matrix, d = LENSES["rectilinear"]
    found = new_camera_matrix(Lens("rectilinear", matrix, d), SIZE, alpha)
    expected = cv2.getOptimalNewCameraMatrix(matrix, np.array(d), SIZE, alpha)[0]
    assert np.abs(found - expected).max() < 0.01 * matrix[0, 0], "OpenCV samples the border at nine points"


def test_new_camera_matrix_at_zero_leaves_no_pixel_without_colour() -> None:
    for model, (matrix, d) in LENSES.items():
        lens = Lens(model, matrix, d)
        x, y = remap_tables(lens, new_camera_matrix(lens, SIZE), SIZE)
        inside = (x >= -0.5) & (x <= SIZE[0] - 0.5) & (y >= -0.5) & (y <= SIZE[1] - 0.5)
        assert inside.all(), model


def test_lens_refuses_an_unknown_model_and_wrong_shapes() -> None:
    with pytest.raises(UsageError, match="upgrade"):
        Lens("spline", MATRIX, [0.0])
    with pytest.raises(UsageError, match="5 coefficients"):
        Lens("rectilinear", MATRIX, [0.0])
    with pytest.raises(UsageError, match=r"\(n, 3\)"):
        Lens("rectilinear", MATRIX, [0.0] * 5).project([[1, 2]])
