"""Every view is a test before it is used."""

import numpy as np
import pytest

from calibsolver import Board, View, fit
from calibsolver.capture import Capture, rules
from calibsolver.quality.cross_validation import MAX_PREDICTION_RATIO, prediction_ratio
from tests.helpers.data import corner_views
from tests.helpers.solver import populations, synthetic

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
