"""Outlier masks do not depend on the start or the order of the views."""

from collections.abc import Sequence

import numpy as np
import pytest

from calibsolver import Calibration, Camera, View, fit
from tests.helpers import data
from tests.helpers.marks import thorough
from tests.helpers.solver.computed_once import fit_once

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


def assert_same(one: Calibration, used: Sequence[np.ndarray], intrinsics: np.ndarray) -> None:
    assert all(np.array_equal(a, b) for a, b in zip(one.used, used, strict=True))
    deviations = np.sqrt(np.diagonal(one.covariance))
    assert np.abs((intrinsics - one.camera.intrinsics) / deviations).max() < SHIFT_DEVIATIONS


@pytest.mark.parametrize(("name", "model", "chosen"), KNIFE_EDGES + WHOLE)
def test_start_and_order_leave_the_mask(name: str, model: str, chosen: Sequence[int]) -> None:
    every, size = data.corner_views(name)
    views: list[View] = [view for i, view in enumerate(every) if i in chosen]
    first = fit_once(views, size, model)
    for focal in FOCAL_WIDTHS:
        f, center = focal * size[0], [(size[0] - 1) / 2, (size[1] - 1) / 2]
        start = Camera.from_intrinsics("rectilinear", np.array([f, f, *center, 0, 0, 0, 0, 0]), size)
        other = fit(views, size, model, start=start)
        assert_same(first, other.used, other.camera.intrinsics)
    order = np.random.default_rng(0).permutation(len(views)).tolist()
    shuffled = fit([views[i] for i in order], size, model)
    back = np.argsort(order)
    assert_same(first, [shuffled.used[i] for i in back], shuffled.camera.intrinsics)
