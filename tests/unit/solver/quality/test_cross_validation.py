"""Scores with the poses fitted alone, cross-validation, predictions, and the choice of a model."""

import numpy as np
import pytest

from calibsolver import Board, CalibrationError, Camera, View, fit, models, rotation
from calibsolver.capture import Capture, rules
from calibsolver.fitting.resection import reprojection_score
from calibsolver.quality.cross_validation import MAX_PREDICTION_RATIO, HeldOut, held_out, prediction_ratio
from calibsolver.quality.model_selection import not_significantly_worse, suggest_model
from tests.helpers.data import available, corner_views, external_data
from tests.helpers.marks import thorough
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


def test_poses_are_those_of_the_least_squares_fit() -> None:
    """On the views that a camera was fitted to, its score is the error of the fit."""
    views, size = corner_views("opencv_left")
    calibration = fit(views, size, robust=False)
    result = reprojection_score(calibration.camera, views)
    assert result.rms == pytest.approx(calibration.avg_reprojection_error, rel=1e-6)
    turns, expected = (rotation.matrix(poses[:, :3]) for poses in (result.poses, calibration.poses))
    assert turns == pytest.approx(expected, abs=1e-3)


@external_data
def test_no_fold_diverges() -> None:
    """On one training fold of arizonat_fe cv2.fisheye diverges without a word (85 px held out)."""
    assert held_out(*corner_views("arizonat_fe"), "fisheye").rms < 0.18


def test_unprojectable_views_have_no_finite_score() -> None:
    """A view beyond the edge of a folding lens is not explained; no number pretends it is."""
    matrix = np.array([[800, 0, 640], [0, 800, 360], [0, 0, 1]])
    narrow = Camera("rectilinear", matrix, [-0.9, 0, 0, 0, 0], synthetic.IMG_SIZE)
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


CAMERAS = synthetic.rectilinear_cameras()


def test_views_are_as_far_off_as_predicted() -> None:
    """Fitted to n views, the next is off by as much as predicted, rms; hardly ever by twice as much."""
    ratios = []
    for i, camera in list(enumerate(CAMERAS))[::2]:
        views = populations.views(camera, np.random.default_rng(i), count=5)
        for n in (2, 3, 4):
            calibration = fit(views[:n], camera.img_size)
            view = views[n]
            ratios.append(prediction_ratio(calibration, view, np.ones(len(view), bool), 0.05))
    assert 0.8 < np.sqrt(np.mean(np.square(ratios))) < 1.25
    assert np.mean(np.array(ratios) > MAX_PREDICTION_RATIO) <= 0.03


def test_failed_prediction_gives_advice_and_continues(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rules, "find_better_model", lambda *_: None)
    camera = CAMERAS[6]
    *views, view = populations.views(camera, np.random.default_rng(0), count=4)
    capture = Capture(Board(), camera.img_size, target_error=50.0)
    # The lens as it is elsewhere: bent by some pixels more than the views so far told.
    off = view.image_points - np.array(camera.img_size) / 2
    bent = view.image_points + 0.012 * off * np.linalg.norm(off, axis=1, keepdims=True) / 500
    good = capture.judge(views, None, view).estimate
    other = capture.judge(views, None, View(view.object_points, bent)).estimate
    assert good is not None
    assert good.converged
    assert good.advice == ()
    assert other is not None
    assert not other.converged
    assert other.progress <= 0.95
    assert "prediction_disagrees" in [advice.code for advice in other.advice]


def test_too_simple_model_gets_a_suggestion() -> None:
    """Photographs through a fisheye, taken as if by a plain lens."""
    views, size = corner_views("jy_left")
    estimate = Capture(Board(), size, target_error=1e-3).judge(views[:7], None, views[7]).estimate
    assert estimate is not None
    assert estimate.suggested_model in ("fisheye", "rational", "omnidirectional")
    assert "model_too_simple" in [advice.code for advice in estimate.advice]


WIDE = {"fisheye", "rational", "omnidirectional"}
EXPECTED = {
    "opencv_left": {"rectilinear"},
    "pv_charuco_480": {"rectilinear"},
    "pv_charuco_1280": {"rectilinear"},
    "pv_picam_320": {"rectilinear"},
    "jy_left": WIDE,
    "derlunz": WIDE,
    "ocam_fisheye2": {"fisheye", "omnidirectional"},
    "babel_ov_plane": {"fisheye", "omnidirectional"},
}


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("opencv_left", slice(0, None, 2)),
        ("jy_left", slice(2, None, 4)),
        *thorough(*((name, slice(0, None, 2)) for name in available(EXPECTED))),
    ],
)
def test_suggested_model_of_real_lenses(name: str, part: slice) -> None:
    views, size = corner_views(name)
    choice = suggest_model(views[part], size)
    assert choice.model in EXPECTED[name]
    assert set(choice.held_out) == set(models.NAMES)
    least = min(error for error in choice.held_out.values() if error is not None)
    found = choice.held_out[choice.model]
    assert found is not None
    assert found < 1.1 * least
    assert choice.model in choice.reasons[0]
    assert len(choice.reasons) == len(models.NAMES)


def test_wild_corners_do_not_decide() -> None:
    camera = synthetic.fisheye_cameras()[2]
    rng = np.random.default_rng(1)
    views = []
    for view in populations.views(camera, rng, count=3):
        q = view.image_points.copy()
        q[rng.integers(len(q))] += 30
        views.append(View(view.object_points, q))
    choice = suggest_model(views, camera.img_size)
    assert choice.model in WIDE
    found = choice.held_out[choice.model]
    assert found is not None
    assert found < 0.4


def test_unfittable_views_raise_calibration_error() -> None:
    rng = np.random.default_rng(0)
    camera = synthetic.rectilinear_cameras()[4]
    views = [
        View(v.object_points[::4], rng.uniform(0, 700, v.image_points[::4].shape))
        for v in populations.views(camera, rng, count=1)
    ]
    with pytest.raises(CalibrationError):
        suggest_model(views, camera.img_size)


@pytest.mark.parametrize(("count", "critical"), [(5, 2.132), (10, 1.833), (21, 1.725)])
def test_models_are_compared_by_a_paired_t_test(count: int, critical: float) -> None:
    """Student's one-sided 5 % quantiles; one standard error more is still as good."""
    best = np.random.default_rng(count).uniform(0.2, 0.6, count)
    noise = np.random.default_rng(1).normal(size=count)
    noise = 0.3 * (noise - noise.mean()) / noise.std(ddof=1)
    for t, as_good in ((1.2, True), (critical - 0.06, True), (critical + 0.06, False)):
        errors = best * np.exp(noise + t * 0.3 / np.sqrt(count))
        one, other = (HeldOut(float(np.sqrt(np.mean(e**2))), e) for e in (errors, best))
        assert one.rms > 1.03 * other.rms
        assert not_significantly_worse(one, other) == as_good
