"""Rivals: other models widen the error where no board has been, and nowhere else."""

import numpy as np
import pytest

from calibsolver import Camera
from calibsolver.camera import pixel_grid
from calibsolver.fitting.coverage import Coverage, record_covered
from calibsolver.fitting.uncertainty import Hull, Rival, Rivals
from calibsolver.quality.rivals import with_rivals
from tests.bench.extrapolation import corner_hull, errors
from tests.helpers.data import corner_views
from tests.helpers.marks import corner_sets
from tests.helpers.solver.computed_once import fit_once

GRID = (20, 15)


@pytest.mark.parametrize("name", corner_sets(["opencv_left", "jy_left"]))
def test_error_outside_the_hull_is_below_the_stated_maximum(name: str) -> None:
    """Half of the views, against all with the best model."""
    views, size = corner_views(name)
    model = {"opencv_left": "rectilinear", "jy_left": "omnidirectional"}[name]
    best = fit_once(views, size, model).camera
    part = views[1::2]
    plain = fit_once(part, size, "omnidirectional")
    whole, outside = with_rivals(plain, part), ~corner_hull(part, plain)
    error = np.nanmax(errors(best, plain.camera, ~outside)[outside])
    assert error < whole.uncertainty().max
    assert whole.uncertainty().max > plain.uncertainty().max


def test_inside_the_hull_nothing_changes() -> None:
    views, size = corner_views("opencv_left")
    plain = fit_once(views, size)
    whole = with_rivals(plain, views)
    assert whole.rivals is not None
    assert whole.rivals.rivals
    inside = whole.rivals.hull.contains(pixel_grid(size, GRID).reshape(2, -1).T).reshape(GRID[1], GRID[0])
    before, after = plain.projection_std(GRID), whole.projection_std(GRID)
    np.testing.assert_array_equal(after[inside], before[inside])
    assert (after[~inside] >= before[~inside]).all()
    assert after[~inside].max() > 2 * before[~inside].max()
    coverage = Coverage.of(whole, views)
    assert coverage == Coverage.of(plain, views)
    assert record_covered(whole, coverage)["uncertainty"]["max"] == whole.uncertainty().max


def test_models_that_explain_less_are_no_rivals() -> None:
    views, size = corner_views("jy_left")  # a lens that the rectilinear model cannot follow
    found = with_rivals(fit_once(views, size, "omnidirectional"), views)
    assert found.rivals is not None
    assert "rectilinear" not in {rival.camera.model for rival in found.rivals.rivals}


def test_a_turned_camera_is_no_rival() -> None:
    camera = fit_once(*corner_views("opencv_left")).camera
    w, h = camera.img_size
    hull = Hull.of(np.array([[w / 4, h / 4], [3 * w / 4, h / 4], [3 * w / 4, 3 * h / 4], [w / 4, 3 * h / 4]]))
    certain = np.zeros((9, 9))
    assert Rivals((Rival(camera, certain),), hull).square_error(camera, GRID).max() < 1e-9
    longer = Camera(
        camera.model, camera.matrix * [[1.01, 1, 1], [1, 1.01, 1], [1, 1, 1]], camera.distortion, (w, h)
    )
    away = np.sqrt(Rivals((Rival(longer, certain),), hull).square_error(camera, GRID))
    assert away.max() == pytest.approx(0.01 * np.hypot(0.5, 0.5) * np.hypot(w, h), rel=0.5)


def test_uncertainty_states_the_share_of_the_picture_it_stands_for() -> None:
    views, size = corner_views("jy_left")
    assert fit_once(views, size, "omnidirectional").uncertainty().coverage == 1
    assert fit_once(views, size, "rectilinear").uncertainty().coverage < 1
