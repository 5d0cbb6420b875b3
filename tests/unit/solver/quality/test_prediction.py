"""Every view is a test before it is used, and what others measured is a beginning, not a result."""

import numpy as np
import pytest

from calibsolver import Board, Camera, View, fit
from calibsolver.capture import Capture
from calibsolver.quality.prediction import MAX_PREDICTION_RATIO, prediction_ratio
from tests.helpers.data import corner_views
from tests.helpers.marks import thorough
from tests.helpers.solver import populations, synthetic

BOARD = Board()
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


def test_failed_prediction_gives_advice_and_continues() -> None:
    camera = CAMERAS[6]
    *views, view = populations.views(camera, np.random.default_rng(0), count=4)
    rules = Capture(BOARD, camera.img_size, target_error=50.0)
    # The lens as it is elsewhere: bent by some pixels more than the views so far told.
    off = view.image_points - np.array(camera.img_size) / 2
    bent = View(
        view.object_points, view.image_points + 0.012 * off * (np.linalg.norm(off, axis=1) / 500)[:, None]
    )
    honest, other = (rules.judge(views, None, v) for v in (view, bent))
    assert honest.estimate is not None
    assert honest.estimate.converged
    assert honest.estimate.advice == ()
    assert other.estimate is not None
    assert not other.estimate.converged
    assert other.estimate.progress <= 0.95
    assert "prediction_disagrees" in [advice.code for advice in other.estimate.advice]


def test_too_simple_model_gets_a_suggestion() -> None:
    """Photographs through a fisheye, taken as if by a plain lens."""
    views, size = corner_views("jy_left")
    rules = Capture(BOARD, size, target_error=1e-3)
    taken = list(views[:6])
    estimate, suggested, advice = rules.estimate(taken), None, set[str]()
    for view in views[6:12]:
        decision = rules.judge(taken, None, view, estimate.excluded)
        if decision.estimate is not None:
            taken, estimate = [*taken, view], decision.estimate
            suggested = suggested or estimate.suggested_model
            advice |= {a.code for a in estimate.advice}
        if suggested and advice >= {"prediction_disagrees", "model_too_simple"}:
            break
    assert suggested in ("fisheye", "rational", "omnidirectional")
    assert advice >= {"prediction_disagrees", "model_too_simple"}


def squashed(camera: Camera, factor: float) -> Camera:
    matrix = camera.matrix.copy()
    matrix[0, 0] *= factor
    matrix[1, 1] *= factor
    return Camera(camera.model, matrix, camera.distortion, camera.img_size)


@pytest.mark.parametrize(
    ("factor", "numbers"), [(0.6, (10,)), *thorough((0.6, (1,)), (1.0, (1, 10)), (1.3, (1, 10)))]
)
def test_seed_starts_a_capture_and_does_not_end_it(factor: float, numbers: tuple[int, ...]) -> None:
    """Right or wrong, the prior leaves no trace in the result."""
    for i in numbers:
        camera = CAMERAS[i]
        prior = squashed(camera, factor)
        rules = Capture(BOARD, camera.img_size, seed=prior)
        assert rules.camera(None).matrix[0, 0] == pytest.approx(prior.matrix[0, 0])
        session = synthetic.run(camera, np.random.default_rng(i), views=6, capture=rules)
        assert session.stopped is not None
        # Longer than five views only where the target is not reached with them.
        five = fit(session.views[:5], camera.img_size).camera
        assert session.stopped <= 5 or (session.stopped == 6 and synthetic.rms_error(camera, five) > 0.3)
        without = Capture(BOARD, camera.img_size).estimate(session.views)
        assert without.calibration is not None
        assert session.calibration is not None
        difference = synthetic.projection_error(without.calibration.camera, session.calibration.camera)
        assert difference.max() < 1e-3


@pytest.mark.parametrize("focal", [3.0, 1e6, np.nan])
def test_malformed_seed_is_ignored(focal: float) -> None:
    matrix = np.array([[focal, 0, 640], [0, focal, 360], [0, 0, 1.0]])
    rules = Capture(BOARD, (1280, 720), seed=Camera("rectilinear", matrix, np.zeros(5), (1280, 720)))
    assert rules.camera(None).matrix[0, 0] == pytest.approx(1024)
