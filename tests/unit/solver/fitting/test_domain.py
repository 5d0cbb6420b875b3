"""Domain prior: the model covers the image unless the points contradict it."""

import numpy as np
import pytest

from calibsolver import fit, models
from calibsolver.fitting import domain
from calibsolver.quality.cross_validation import held_out
from tests.helpers.data import corner_views
from tests.helpers.marks import corner_sets
from tests.helpers.solver.computed_once import fit_once


def without_prior(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(domain, "covering", lambda *_: None)


@pytest.mark.parametrize("name", corner_sets(["mint_isaw", "derlunz", "ocam_fisheye2"]))
def test_rational_domain_covers_the_image_at_no_cost(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    views, size = corner_views(name)
    found, error = fit(views, size, "rational"), held_out(views, size, "rational").rms
    without_prior(monkeypatch)
    before = fit(views, size, "rational")
    assert before.camera.domain().covered < 0.97
    assert found.camera.domain().covered == 1
    assert found.rms_inliers < 1.001 * before.rms_inliers
    assert error < 1.01 * held_out(views, size, "rational").rms


@pytest.mark.parametrize("model", ["rectilinear", "rational"])
@pytest.mark.parametrize(("name", "is_covered"), [("jy_left", False), ("opencv_left", True)])
def test_covered_images_and_points_that_contradict_the_prior_win(
    name: str, is_covered: bool, model: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    views, size = corner_views(name)
    found = fit_once(views, size, model)
    assert (found.camera.domain().covered >= 0.9) == is_covered
    without_prior(monkeypatch)
    np.testing.assert_array_equal(fit(views, size, model).camera.intrinsics, found.camera.intrinsics)


@pytest.mark.parametrize("model", models.NAMES)
def test_excess_is_positive_where_the_domain_ends_inside_the_image(model: str) -> None:
    views, size = corner_views("jy_left")
    camera = fit_once(views, size, model).camera
    over = domain.excess(models.get(model), camera.intrinsics, size)
    assert (over > 0.1) == (camera.domain().covered < 0.999)


def test_gradient_is_that_of_the_excess() -> None:
    views, size = corner_views("jy_left")
    model, camera = models.get("rectilinear"), fit_once(views, size).camera
    k, step = camera.intrinsics, np.array([1, -0.5, 0.3, 0.2, 1e-3, -1e-3, 1e-6, 1e-6, 1e-4])
    moved = domain.excess(model, k + 1e-3 * step, size) - domain.excess(model, k - 1e-3 * step, size)
    assert domain.gradient(model, k, size) @ step == pytest.approx(moved / 2e-3, rel=1e-3)
