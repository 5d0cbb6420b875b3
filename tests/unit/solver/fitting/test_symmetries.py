"""Invariance of a fit to order, to the unit of the board, and of its outliers to the start."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calibsolver import Camera, View, fit
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


FOCAL_WIDTHS = (0.6, 1.1)
SHIFT_DEVIATIONS = 1e-3
EVERY = range(10**3)
#: views of which a loose robust stage made masks that depended on the start
KNIFE_EDGES = [
    ("jy_left", "rectilinear", (4, 8, 9, 16, 18, 22, 30, 31)),
    ("jy_left", "rectilinear", (0, 5, 11, 14, 15, 25)),
    ("opencv_left", "rectilinear", (1, 2, 5, 8, 10, 11, 12)),
    ("opencv_left", "rectilinear", (0, 1, 3, 9, 10, 11, 12)),
    ("opencv_right", "rectilinear", (3, 5, 9, 10, 12)),
]
WHOLE = [
    ("jy_left", "rectilinear", EVERY),
    ("jy_left", "fisheye", EVERY),
    ("opencv_left", "rectilinear", EVERY),
    ("opencv_left", "fisheye", EVERY),
    *thorough(("opencv_right", "rectilinear", EVERY), ("opencv_right", "fisheye", EVERY)),
    *thorough(("babel_ov_plane", "fisheye", EVERY), ("babel_ov_plane", "omnidirectional", EVERY)),
]


@pytest.mark.parametrize(("name", "model", "chosen"), KNIFE_EDGES + WHOLE)
def test_start_leaves_the_mask(name: str, model: str, chosen: Sequence[int]) -> None:
    every, size = corner_views(name)
    views: list[View] = [view for i, view in enumerate(every) if i in chosen]
    first = fit_once(views, size, model)
    for focal in FOCAL_WIDTHS:
        f, center = focal * size[0], [(size[0] - 1) / 2, (size[1] - 1) / 2]
        start = Camera.from_intrinsics("rectilinear", np.array([f, f, *center, 0, 0, 0, 0, 0]), size)
        other = fit(views, size, model, start=start)
        assert all(np.array_equal(a, b) for a, b in zip(first.used, other.used, strict=True))
        deviations = np.sqrt(np.diagonal(first.covariance))
        shift = other.camera.intrinsics - first.camera.intrinsics
        assert np.abs(shift / deviations).max() < SHIFT_DEVIATIONS
