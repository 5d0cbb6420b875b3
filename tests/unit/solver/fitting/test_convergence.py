"""Steps of the solver: how many it takes, and where they begin."""

from typing import Any

import numpy as np
import pytest

from calibsolver import fit, models
from calibsolver.fitting.initial_guess import focal_sweep
from calibsolver.fitting.levenberg_marquardt import Options, Problem
from calibsolver.fitting.normal_equations import Poses
from calibsolver.fitting.observations import Observations
from calibsolver.fitting.robust_covariance import cluster_grams, with_more_points
from tests.helpers import data


def count_calls(monkeypatch: pytest.MonkeyPatch, name: str) -> list[str]:
    """Names of the calls of a method of problems from now on."""
    calls: list[str] = []
    method = getattr(Problem, name)

    def counted(*arguments: Any) -> Any:
        calls.append(name)
        return method(*arguments)

    monkeypatch.setattr(Problem, name, counted)
    return calls


def test_model_that_is_too_simple_settles_in_few_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the correction of steps it takes two linearizations more."""
    views, img_size = data.corner_views("jy_left")
    obs = Observations.of(views)
    problem = Problem(models.get("rectilinear"), obs, img_size)
    optimum = fit(views, img_size, board_shape=False)
    k = optimum.camera.intrinsics
    k[:2] *= 1.02
    k[4:] *= 1.05
    begun = problem.at(k, Poses.of_vectors(optimum.poses))
    calls = count_calls(monkeypatch, "at")
    state = problem.solve(begun, obs.mask, Options())
    assert state.converged
    assert len(calls) <= 6
    deviations = np.sqrt(np.diagonal(optimum.covariance))
    assert np.abs((state.k - optimum.camera.intrinsics) / deviations).max() < 1e-3


def test_gram_matrices_with_more_points_are_those_of_all_of_them() -> None:
    rng = np.random.default_rng(1)
    rows, effects = rng.standard_normal((14, 2, 6, 20)), rng.standard_normal((3, 2, 6, 20))
    labels, used = np.array([0, 1, 0, 2, 1, 3]), rng.random((6, 20)) > 0.2
    seen = used.copy()
    seen[[0, 3]] = True
    expected, fewer = (cluster_grams(rows, effects, labels, points) for points in (seen, used))
    more = with_more_points(fewer, rows, effects, labels, used, seen)
    np.testing.assert_allclose(more, expected, rtol=0, atol=1e-10)


def test_omnidirectional_fit_goes_straight_along_its_valley(monkeypatch: pytest.MonkeyPatch) -> None:
    """With boards that move by the generalised focal length it takes 120 linearizations."""
    views, img_size = data.corner_views("jy_left")
    calls = count_calls(monkeypatch, "_take_step")
    fit(views, img_size, "omnidirectional", board_shape=False)
    assert len(calls) <= 40


@pytest.mark.parametrize("name", ["opencv_left", "opencv_right", "jy_left"])
def test_sweep_puts_a_near_focal_length_first(name: str) -> None:
    views, img_size = data.corner_views(name)
    best = focal_sweep(models.get("rectilinear"), Observations.of(views), img_size)[0]
    assert abs(np.log(best.k[0] / fit(views, img_size).camera.focal[0])) < np.log(1.25)
