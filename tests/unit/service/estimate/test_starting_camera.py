"""Initial camera of a capture from an estimate, for every model that a session may have."""

import math

import numpy as np
import pytest

from calibdb.estimate.estimator import EstimateQuery, starting_camera
from calibsolver import Board, Camera
from calibsolver.capture import Capture
from tests.bench import first_views
from tests.helpers.solver import synthetic

C920 = EstimateQuery("HD Pro Webcam C920 (046d:082d)", "X11; Linux x86_64", (1280, 720))
GOPRO = EstimateQuery("GoPro HERO7 Black", "video", (1920, 1440))


@pytest.mark.parametrize("query", [C920, GOPRO, EstimateQuery("-", "x", (720, 1280))])
@pytest.mark.parametrize("model", ["rectilinear", "rational", "fisheye"])
def test_capture_takes_it_as_a_seed(query: EstimateQuery, model: str) -> None:
    record = starting_camera(query, model)
    assert record is not None
    camera = Camera.from_record(record.model_dump())
    assert Capture(Board(), query.img_size, model, seed=camera).seed is not None


@pytest.mark.parametrize("model", ["rectilinear", "rational", "fisheye"])
def test_models_have_one_field_of_view(model: str) -> None:
    record = starting_camera(C920, model)
    assert record is not None
    camera = Camera.from_record(record.model_dump())
    w, h = camera.img_size
    left, right = camera.unproject(np.array([[-0.5, (h - 1) / 2], [w - 0.5, (h - 1) / 2]]))
    angle = math.degrees(math.acos(np.dot(left, right) / np.linalg.norm(left) / np.linalg.norm(right)))
    assert angle == pytest.approx(66.9, abs=0.5)


def test_no_other_model_is_guessed() -> None:
    assert starting_camera(C920, "omnidirectional") is None


def test_first_views_from_an_estimate_are_accepted_as_often_as_from_the_flat_guess(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    cameras = synthetic.rectilinear_cameras()[::3]
    monkeypatch.setattr(synthetic, "rectilinear_cameras", lambda: cameras)
    flat = first_views.first_accepted(None, seeds=1)
    assert first_views.first_accepted(0.15, seeds=1) >= flat


@pytest.mark.thorough
def test_captures_from_an_estimate_need_no_more_views() -> None:
    flat = first_views.measure(None)
    for sigma in (0.03, 0.15):
        found = first_views.measure(sigma)
        assert found.first >= flat.first
        assert found.views <= flat.views + 0.05  # one of 72 captures
