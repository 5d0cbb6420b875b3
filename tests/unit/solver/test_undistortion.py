"""Rectified pictures of one camera."""

import cv2
import numpy as np
import pytest

from calibsolver import CalibrationError, Camera
from calibsolver.arrays import Array
from calibsolver.undistortion import new_camera_matrix, remap_tables
from tests.helpers.data import corner_views
from tests.helpers.marks import corner_sets, thorough
from tests.helpers.solver.computed_once import fit_once

SIZE = (320, 180)
MATRIX = np.array([[237.0, 0, 163], [0, 237, 87], [0, 0, 1]])
WIDE = np.array([[105.0, 0, 163], [0, 104, 87], [0, 0, 1]])
CAMERAS = {
    "rectilinear": (MATRIX, [-0.32, 0.12, 0.0005, -0.0004, -0.02]),
    "fisheye": (WIDE, [0.02, -0.01, 0.004, -0.001]),
    "rational": (MATRIX, [0.5, -0.2, 0.0003, 0.0002, 0.01, 0.7, -0.1, 0.02]),
    "omnidirectional": (WIDE, [0.9, -0.05, 0.01, 0.0004, -0.0003]),
}
# The radial derivative vanishes at 49 degrees: the corners of the picture have no ray.
FOLDED = Camera("rectilinear", WIDE, np.array([-0.25, 0.0, 0.0, 0.0, 0.0]), SIZE)


def camera_of(model: str) -> Camera:
    matrix, d = CAMERAS[model]
    return Camera(model, matrix, np.array(d), SIZE)


@pytest.mark.parametrize("model", ["rectilinear", "rational", "fisheye"])
def test_remap_tables_equal_opencvs(model: str) -> None:
    matrix, d = CAMERAS[model]
    new = matrix * [[0.8], [0.8], [1]]
    tables = remap_tables(camera_of(model), new)
    make = cv2.fisheye.initUndistortRectifyMap if model == "fisheye" else cv2.initUndistortRectifyMap
    expected = make(matrix, np.array(d), np.eye(3), new, SIZE, cv2.CV_32FC1)
    for one, other in zip(tables, expected, strict=True):
        inside = one >= 0
        assert inside.mean() > 0.9
        assert np.abs(one - other)[inside].max() < 1e-2


@pytest.mark.parametrize("alpha", [0.0, 0.4, 1.0])
def test_new_camera_matrix_is_near_opencvs(alpha: float) -> None:
    matrix, d = CAMERAS["rectilinear"]
    expected = cv2.getOptimalNewCameraMatrix(matrix, np.array(d), SIZE, alpha)[0]
    difference = new_camera_matrix(camera_of("rectilinear"), alpha) - expected
    assert np.abs(difference).max() < 0.01 * matrix[0, 0], "OpenCV samples the border at nine points"


def share_with_colour(camera: Camera, matrix: Array) -> float:
    x, y = remap_tables(camera, matrix)
    w, h = camera.img_size
    return float(((x >= -0.5) & (x <= w - 0.5) & (y >= -0.5) & (y <= h - 0.5)).mean())


def test_new_camera_matrix_at_zero_leaves_no_pixel_without_colour() -> None:
    cameras = [camera_of(model) for model in CAMERAS]
    assert [share_with_colour(camera, new_camera_matrix(camera)) for camera in cameras] == [1.0] * 4


def test_camera_without_rays_at_the_border_has_a_new_matrix_and_no_pixel_without_colour() -> None:
    assert 0.3 < FOLDED.domain().covered < 0.9
    whole, part = new_camera_matrix(FOLDED, 1.0), new_camera_matrix(FOLDED)
    assert share_with_colour(FOLDED, part) == 1.0
    assert 0 < whole[0, 0] < part[0, 0]
    x, _ = remap_tables(FOLDED, whole)
    assert (x >= 0).mean() > 0.5


def test_values_that_cannot_be_used_are_refused() -> None:
    with pytest.raises(CalibrationError, match="alpha"):
        new_camera_matrix(FOLDED, 1.5)
    with pytest.raises(CalibrationError, match="invertible"):
        remap_tables(FOLDED, np.zeros((3, 3)))


@pytest.mark.parametrize("name", corner_sets(["mint_isaw", "jy_left"]))
@pytest.mark.parametrize("model", ["fisheye", *thorough("rectilinear", "rational", "omnidirectional")])
def test_real_calibrations_have_a_new_matrix(name: str, model: str) -> None:
    views, size = corner_views(name)
    camera = fit_once(views, size, model).camera
    assert np.isfinite(new_camera_matrix(camera, 1.0)).all()
    assert share_with_colour(camera, new_camera_matrix(camera)) > 0.999
