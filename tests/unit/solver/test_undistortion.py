"""Rectified pictures of one camera."""

import cv2
import numpy as np
import pytest

from calibsolver import CalibrationError, Camera, models
from calibsolver.arrays import Array
from calibsolver.image_transform import resize
from calibsolver.undistortion import new_camera_matrix, remap_tables
from tests.helpers.data import corner_views
from tests.helpers.marks import corner_sets
from tests.helpers.solver.computed_once import fit_once
from tests.helpers.solver.export_sources import IMG_SIZE, truth

SIZE = (320, 180)
SMALLER = resize(IMG_SIZE, SIZE)
# The radial derivative vanishes at 49 degrees: the corners of the picture have no ray.
FOLDED = Camera("rectilinear", SMALLER.camera(truth("fisheye")).matrix, [-0.25, 0.0, 0.0, 0.0, 0.0], SIZE)


def camera_of(model: str) -> Camera:
    return SMALLER.camera(truth(model))


@pytest.mark.parametrize("model", ["rectilinear", "rational", "fisheye"])
def test_remap_tables_equal_opencvs(model: str) -> None:
    camera = camera_of(model)
    new = camera.matrix * [[0.8], [0.8], [1]]
    tables = remap_tables(camera, new)
    make = cv2.fisheye.initUndistortRectifyMap if model == "fisheye" else cv2.initUndistortRectifyMap
    expected = make(camera.matrix, camera.distortion, np.eye(3), new, SIZE, cv2.CV_32FC1)
    for one, other in zip(tables, expected, strict=True):
        inside = one >= 0
        assert inside.mean() > 0.9
        assert np.abs(one - other)[inside].max() < 1e-2


@pytest.mark.parametrize("alpha", [0.0, 0.4, 1.0])
def test_new_camera_matrix_is_near_opencvs(alpha: float) -> None:
    camera = camera_of("rectilinear")
    expected = cv2.getOptimalNewCameraMatrix(camera.matrix, camera.distortion, SIZE, alpha)[0]
    difference = new_camera_matrix(camera, alpha) - expected
    assert np.abs(difference).max() < 0.01 * camera.matrix[0, 0], "OpenCV samples the border at nine points"


def share_with_colour(camera: Camera, matrix: Array) -> float:
    x, y = remap_tables(camera, matrix)
    w, h = camera.img_size
    return float(((x >= -0.5) & (x <= w - 0.5) & (y >= -0.5) & (y <= h - 0.5)).mean())


def test_new_camera_matrix_at_zero_leaves_no_pixel_without_colour() -> None:
    cameras = [camera_of(model) for model in models.NAMES]
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
def test_real_calibration_has_a_new_matrix(name: str) -> None:
    camera = fit_once(*corner_views(name), "fisheye").camera
    assert np.isfinite(new_camera_matrix(camera, 1.0)).all()
    assert share_with_colour(camera, new_camera_matrix(camera)) > 0.999
