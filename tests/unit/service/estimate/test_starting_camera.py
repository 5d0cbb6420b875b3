"""Initial camera of a capture from an estimate, for every model that a session may have."""

import math
import statistics
from collections.abc import Iterator, Sequence

import numpy as np
import pytest

from calibdb.estimate.estimator import EstimateQuery, starting_camera
from calibsolver import Board, Camera
from calibsolver.capture import Capture
from tests.helpers.solver import synthetic

C920 = EstimateQuery("HD Pro Webcam C920 (046d:082d)", "X11; Linux x86_64", (1280, 720))
GOPRO = EstimateQuery("GoPro HERO7 Black", "video", (1920, 1440))


@pytest.mark.parametrize("query", [C920, GOPRO, EstimateQuery("-", "x", (720, 1280))])
@pytest.mark.parametrize("model", ["rectilinear", "rational", "fisheye"])
def test_capture_takes_it_as_a_seed(query: EstimateQuery, model: str) -> None:
    camera = Camera.from_record(starting_camera(query, model).model_dump())
    assert Capture(Board(), query.img_size, model, seed=camera).seed is not None


@pytest.mark.parametrize("model", ["rectilinear", "rational", "fisheye"])
def test_models_have_one_field_of_view(model: str) -> None:
    camera = Camera.from_record(starting_camera(C920, model).model_dump())
    w, h = camera.img_size
    left, right = camera.unproject(np.array([[-0.5, (h - 1) / 2], [w - 0.5, (h - 1) / 2]]))
    angle = math.degrees(math.acos(np.dot(left, right) / np.linalg.norm(left) / np.linalg.norm(right)))
    assert angle == pytest.approx(66.9, abs=0.5)


def test_no_other_model_is_guessed() -> None:
    assert starting_camera(C920, "omnidirectional") is None


def test_first_views_from_an_estimate_are_accepted_as_often_as_from_the_flat_guess() -> None:
    cameras = synthetic.rectilinear_cameras()[::3]
    assert first_accepted(0.15, cameras, 1) >= first_accepted(None, cameras, 1)


@pytest.mark.thorough
def test_captures_from_an_estimate_need_no_more_views() -> None:
    world = synthetic.rectilinear_cameras(), 6
    first, views = first_accepted(None, *world), mean_views(None, *world)
    for sigma in SIGMAS:
        assert first_accepted(sigma, *world) >= first
        assert mean_views(sigma, *world) <= views + 0.05  # one of 72 captures


SIGMAS = (0.03, 0.15)
"""Deviation of the logarithm of an estimate's focal length: of a published model, of a kind of device."""
MAX_VIEWS = 15


def first_accepted(sigma: float | None, cameras: Sequence[Camera], seeds: int) -> float:
    """Share of the first guided views that are accepted; `sigma`: None starts from the flat guess."""
    sessions = captures(sigma, cameras, seeds, views=1, max_attempts=1)
    return statistics.fmean(len(session.views) for session in sessions)


def mean_views(sigma: float | None, cameras: Sequence[Camera], seeds: int) -> float:
    """Mean number of views until the end; one that does not end counts as one more than MAX_VIEWS."""
    sessions = captures(sigma, cameras, seeds, views=2, max_views=MAX_VIEWS)
    return statistics.fmean(session.stopped or MAX_VIEWS + 1 for session in sessions)


def captures(
    sigma: float | None, cameras: Sequence[Camera], seeds: int, **options: int
) -> Iterator[synthetic.Session]:
    for index, camera in enumerate(cameras):
        for seed in range(seeds):
            rng = np.random.default_rng([index, seed])
            start = None if sigma is None else pinhole(camera, sigma, rng)
            capture = Capture(Board(), camera.img_size, camera.model, seed=start)
            yield synthetic.run(camera, np.random.default_rng(100 * index + seed), capture=capture, **options)


def pinhole(camera: Camera, sigma: float, rng: np.random.Generator) -> Camera:
    w, h = camera.img_size
    focal = camera.intrinsics[0] * np.exp(sigma * rng.normal())
    matrix = np.array([[focal, 0, (w - 1) / 2], [0, focal, (h - 1) / 2], [0, 0, 1]])
    return Camera(camera.model, matrix, np.zeros(len(camera.distortion)), camera.img_size)
