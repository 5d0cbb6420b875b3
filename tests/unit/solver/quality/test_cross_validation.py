"""Scores with the poses fitted alone, and cross-validation."""

import numpy as np
import pytest

from calibsolver import CalibrationError, Camera, View, fit, rotation
from calibsolver.fitting.resection import reprojection_score
from calibsolver.quality.cross_validation import held_out
from tests.helpers.data import corner_views, external_data
from tests.helpers.solver import populations, synthetic


@pytest.mark.parametrize("camera", [synthetic.rectilinear_cameras()[4], synthetic.fisheye_cameras()[8]])
def test_the_true_camera_leaves_the_noise(camera: Camera) -> None:
    """Of 2n residuals a pose takes six away; what is left is the noise of the corners."""
    views = populations.views(camera, np.random.default_rng(0), noise=0.3)
    result = reprojection_score(camera, views)
    n = np.array([len(view) for view in views])
    expected = 0.3 * np.sqrt(2 * (1 - 3 / n))
    assert np.sqrt(np.mean((result.view_errors / expected) ** 2)) == pytest.approx(1, abs=0.06)
    assert result.rms == pytest.approx(np.sqrt(np.average(result.view_errors**2, weights=n)))
    assert result.poses.shape == (len(views), 6)


def test_poses_are_those_of_the_least_squares_fit() -> None:
    """On the views that a camera was fitted to, its score is the error of the fit."""
    views, size = corner_views("opencv_left")
    calibration = fit(views, size, robust=False)
    result = reprojection_score(calibration.camera, views)
    assert result.rms == pytest.approx(calibration.avg_reprojection_error, rel=1e-6)
    np.testing.assert_allclose(
        rotation.matrix(result.poses[:, :3]), rotation.matrix(calibration.poses[:, :3]), atol=1e-3
    )


@external_data
def test_no_fold_diverges() -> None:
    """On one training fold of arizonat_fe cv2.fisheye diverges without a word (85 px held out)."""
    assert held_out(*corner_views("arizonat_fe"), "fisheye").rms < 0.18


def test_unprojectable_views_have_no_finite_score() -> None:
    """A view beyond the edge of a folding lens is not explained; no number pretends it is."""
    narrow = Camera(
        "rectilinear", np.array([[800, 0, 640], [0, 800, 360], [0, 0, 1]]), [-0.9, 0, 0, 0, 0], (1280, 720)
    )
    views = populations.views(synthetic.fisheye_cameras()[11], np.random.default_rng(0))
    assert not reprojection_score(narrow, views).rms < 20


def test_scoring_needs_views_with_points() -> None:
    camera = synthetic.rectilinear_cameras()[4]
    for views, code in (([], "no_views"), ([View(np.zeros((3, 3)), np.zeros((3, 2)))], "too_few_points")):
        with pytest.raises(CalibrationError) as caught:
            reprojection_score(camera, views)
        assert caught.value.code == code


def test_every_view_is_left_out_once() -> None:
    views, size = corner_views("opencv_left")
    result = held_out(views, size)
    assert np.isfinite(result.view_errors).all()
    n = np.array([len(view) for view in views])
    assert result.rms == pytest.approx(np.sqrt(np.average(result.view_errors**2, weights=n)))
    assert np.isfinite(held_out(views[:3], size).view_errors).all()
    with pytest.raises(CalibrationError) as caught:
        held_out(views[:1], size)
    assert caught.value.code == "too_few_views"
