"""What a fit must not depend on: the order of views and points, the unit of the board."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calibsolver import View, fit, models
from tests.data import corner_set

budget = settings(max_examples=3, deadline=None)
SETS = {"rectilinear": "opencv_right", "fisheye": "jy_left", "rational": "jy_left"}


def load(name: str) -> tuple[list[View], tuple[int, int]]:
    data = corner_set(name)
    w, h = data["image_size"]
    return [View(v["obj"], v["img"]) for v in data["views"]], (w, h)


@pytest.mark.parametrize("model", models.NAMES)
@given(seed=st.integers(0, 2**32 - 1), robust=st.booleans())
@budget
def test_order_changes_nothing(model: str, seed: int, robust: bool) -> None:
    views, size = load(SETS.get(model, "mint_isaw"))
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(views))
    mixed = []
    for i in order:
        points = rng.permutation(len(views[i]))
        mixed.append(View(views[i].object_points[points], views[i].image_points[points]))
    a, b = fit(views, size, model, robust), fit(mixed, size, model, robust)
    # Coefficients that nearly replace one another are known to no more digits than the rounding leaves.
    loose = model in ("rational", "omnidirectional")
    allowed = 1e-9 * np.abs(a.camera.intrinsics) + (1e-5 if loose else 1e-8) * np.sqrt(np.diag(a.covariance))
    np.testing.assert_array_less(np.abs(a.camera.intrinsics - b.camera.intrinsics), allowed)
    np.testing.assert_allclose(a.poses[order], b.poses, rtol=1e-6 if loose else 1e-9, atol=1e-9)
    assert a.avg_reprojection_error == pytest.approx(b.avg_reprojection_error, abs=1e-9)


@given(scale=st.floats(1e-3, 1e3))
@budget
def test_scale_of_the_board_scales_translations_alone(scale: float) -> None:
    views, size = load("opencv_right")
    a = fit(views, size)
    b = fit([View(scale * v.object_points, v.image_points) for v in views], size)
    np.testing.assert_allclose(a.camera.intrinsics, b.camera.intrinsics, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(scale * a.poses[:, 3:], b.poses[:, 3:], rtol=1e-8)
    np.testing.assert_allclose(a.poses[:, :3], b.poses[:, :3], atol=1e-9)
