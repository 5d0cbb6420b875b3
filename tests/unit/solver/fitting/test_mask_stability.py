"""Outlier masks of real corners do not depend on where the fit starts."""

from collections.abc import Sequence

import numpy as np
import pytest

from calibsolver import Camera, View, fit
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


@pytest.mark.parametrize(("name", "model", "chosen"), KNIFE_EDGES + WHOLE)
def test_start_leaves_the_mask(name: str, model: str, chosen: Sequence[int]) -> None:
    every, size = data.corner_views(name)
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
