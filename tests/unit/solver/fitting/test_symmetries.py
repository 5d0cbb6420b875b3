"""Invariance of a fit to order and to the unit of the board."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calibsolver import View, fit
from tests.helpers.data import corner_views
from tests.helpers.marks import thorough
from tests.helpers.solver.computed_once import fit_once


@pytest.mark.parametrize("model", ["rectilinear", "fisheye", *thorough("omnidirectional", "rational")])
@pytest.mark.parametrize(("weighted", "robust"), [(False, False), (False, True), (True, True)])
def test_order_changes_nothing(model: str, weighted: bool, robust: bool) -> None:
    views, size = corner_views("opencv_right" if model == "rectilinear" else "jy_left")
    views = views[::3]
    rng = np.random.default_rng(0)
    if weighted:
        views = [replace(view, weights=rng.uniform(0.2, 5, len(view))) for view in views]
    order = rng.permutation(len(views))
    mixed, mixes = [], []
    for i in order:
        points = rng.permutation(len(views[i]))
        mixes.append(points)
        mixed.append(views[i].subset(points))
    a, b = fit_once(views, size, model, robust), fit(mixed, size, model, robust)
    np.testing.assert_array_equal(a.camera.intrinsics, b.camera.intrinsics)
    np.testing.assert_array_equal(a.poses[order], b.poses)
    assert a.avg_reprojection_error == b.avg_reprojection_error
    for i, (j, points) in enumerate(zip(order, mixes, strict=True)):
        np.testing.assert_array_equal(a.residuals[j][points], b.residuals[i])
        np.testing.assert_array_equal(a.used[j][points], b.used[i])


@given(scale=st.floats(1e-3, 1e3))
@settings(max_examples=2)
def test_scale_of_the_board_scales_translations_alone(scale: float) -> None:
    views, size = corner_views("opencv_right")
    a = fit_once(views, size)
    b = fit([View(scale * v.object_points, v.image_points) for v in views], size)
    np.testing.assert_allclose(a.camera.intrinsics, b.camera.intrinsics, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(scale * a.poses[:, 3:], b.poses[:, 3:], rtol=1e-8)
    np.testing.assert_allclose(a.poses[:, :3], b.poses[:, :3], atol=1e-9)
