"""The probable cause of systematic residuals, in simulated hands."""

from contextlib import suppress

import numpy as np
import pytest

from calibsolver import CalibrationError, fit
from calibsolver.capture import Capture
from calibsolver.quality.report import describe
from calibsolver.quality.systematic import probable_cause
from tests.helpers.data import corner_views
from tests.helpers.solver import hands, populations, synthetic

HANDS = [
    (hands.STEADY, None),
    (hands.MOVING, "motion"),
    (hands.BENT, "board_bent"),
    (hands.REFOCUSING, "focus_changed"),
]


@pytest.mark.parametrize(("hand", "cause"), HANDS)
def test_cause_is_named_in_four_of_five_captures(hand: hands.Hand, cause: str | None) -> None:
    named = []
    cameras = list(enumerate(synthetic.rectilinear_cameras()))[::2]
    for i, camera in cameras:
        views = populations.views(camera, np.random.default_rng(i), hand=hand)
        with suppress(CalibrationError):
            found = probable_cause(fit(views, camera.img_size, board_shape=False), views)
            named.append(found.code if found else None)
    assert len(named) >= 0.8 * len(cameras)
    assert named.count(cause) >= 0.8 * len(named)


@pytest.mark.parametrize(("hand", "cause"), HANDS)
def test_capture_advises_what_to_do_about_the_cause(hand: hands.Hand, cause: str | None) -> None:
    """The advice comes first, and says the same as the report. A shape of the board is taken into account."""
    camera = synthetic.rectilinear_cameras()[4]
    views = populations.views(camera, np.random.default_rng(1), hand=hand)
    estimate = Capture(populations.BOARD, camera.img_size).estimate(views).with_cause(views)
    assert estimate.calibration is not None
    advice = {one.code: one.text for one in estimate.advice}
    if cause in (None, "board_bent"):
        assert advice == {}
        return
    assert list(advice) == [cause]
    report = describe(estimate.calibration, views)
    assert report["systematic"]["cause"] == cause
    assert report["systematic"]["text"] == advice[cause]
    assert report["verdict"]["level"] != "good"
    assert cause in [reason["code"] for reason in report["verdict"]["reasons"]]


def test_board_that_bends_in_each_view_is_answered_with_advice() -> None:
    """No shape corrects it."""
    camera, rng = synthetic.rectilinear_cameras()[5], np.random.default_rng(0)
    views = [populations.views(camera, rng, hand=hands.BENT)[n] for n in range(6)]
    rules = Capture(populations.BOARD, camera.img_size, recorded=True)
    (advice,) = rules.estimate(views).with_cause(views).advice
    assert advice.code == "board_bent"
    assert advice.text == (
        "The board bends from view to view: glue it to something rigid, such as glass or a tray."
    )


def test_lens_that_bends_more_than_its_model_is_given_another() -> None:
    """OpenCV's fisheye lens, real, taken as if by a plain lens."""
    views, size = corner_views("jy_left")
    views = views[::2]
    calibration = fit(views, size, board_shape=False)
    cause = probable_cause(calibration, views)
    assert cause is not None
    assert (cause.code, cause.model) == ("model_too_simple", "fisheye")
    assert cause.text == "The lens bends more than the rectilinear model can: choose the fisheye model."
    assert cause.share > 0.5
    described = describe(calibration, views)
    assert described["systematic"]["model"] == "fisheye"
    reasons = {reason["code"]: reason["text"] for reason in described["verdict"]["reasons"]}
    assert reasons["model_too_simple"] == cause.text
    estimate = Capture(populations.BOARD, size, recorded=True).estimate(views).with_cause(views)
    assert estimate.suggested_model == "fisheye"
    assert [advice.code for advice in estimate.advice] == ["model_too_simple"]


def test_small_cause_is_told_and_leaves_the_verdict_good() -> None:
    """A board bent by a twelfth as much: less than the noise of the corners."""
    camera = synthetic.rectilinear_cameras()[5]
    slight = hands.Hand(sag_boards=0.0006)
    views = populations.views(camera, np.random.default_rng(0), hand=slight)
    told = describe(fit(views, camera.img_size, board_shape=False), views)
    assert told["systematic"]["cause"] == "board_bent"
    assert told["verdict"] == {"level": "good", "reasons": []}
