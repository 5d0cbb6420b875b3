"""Bad measurements on real corner sets leave no trace."""

import numpy as np
import pytest

from calibsolver import View, fit
from tests.helpers.data import corner_views
from tests.helpers.marks import corner_sets, thorough
from tests.helpers.solver import synthetic

MODELS = {
    "opencv_left": "rectilinear",
    "opencv_right": "rectilinear",
    "pv_charuco_480": "rectilinear",
    "jy_left": "fisheye",
    "derlunz": "fisheye",
    "mint_isaw": "omnidirectional",
    "babel_ov_plane": "omnidirectional",
}
SLOW = "babel_ov_plane"


CASES = [*corner_sets(name for name in MODELS if name != SLOW), *thorough(SLOW)]


@pytest.mark.parametrize("name", CASES)
def test_points_3_to_50_px_off_leave_no_trace(name: str) -> None:
    """The fit is that of the other points, a quarter of the standard deviation from that of all."""
    views, size = corner_views(name)
    model = MODELS[name]
    clean = fit(views, size, model)
    rng = np.random.default_rng(1)
    dirty, rest = [], []
    for view in views:
        angle, bad = rng.uniform(0, 2 * np.pi, len(view)), rng.uniform(size=len(view)) < 0.05
        off = rng.uniform(3, 50, len(view))[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        dirty.append(View(view.object_points, view.image_points + np.where(bad[:, None], off, 0)))
        rest.append(View(view.object_points[~bad], view.image_points[~bad]))
    found = fit(dirty, size, model)
    assert found.avg_reprojection_error > 5 * clean.avg_reprojection_error  # over all points, as ever
    without = fit(rest, size, model)
    assert synthetic.projection_error(without.camera, found.camera).mean() < 0.02
    lost = synthetic.projection_error(clean.camera, found.camera).mean()
    assert lost < max(0.1, 0.35 * clean.uncertainty().rms)


@pytest.mark.parametrize("name", [name for name in CASES if "pv_charuco_480" not in str(name)])
def test_every_fifth_view_shifted_by_a_corner(name: str) -> None:
    """All corners of it have the next one's name."""
    views, size = corner_views(name)
    model = MODELS[name]
    shifted, rest = list(views), list(views)
    for i in range(0, len(views), 5):
        p, q = views[i].object_points, views[i].image_points
        moved = np.roll(p, -1, axis=0)
        fits = (np.abs(moved - p - np.median(moved - p, axis=0)) < 1e-6).all(axis=1)
        shifted[i], rest[i] = View(moved, q), View(moved[fits], q[fits])
    found, without = fit(shifted, size, model), fit(rest, size, model)
    assert synthetic.projection_error(without.camera, found.camera).mean() < 0.1
    assert not found.cut_views


def test_views_left_out_are_named_with_a_reason() -> None:
    views, size = corner_views("opencv_right")
    rng = np.random.default_rng(0)
    wrong = list(views)
    wrong[2] = View(views[2].object_points, rng.permutation(views[2].image_points))
    wrong[5] = View(views[5].object_points * [-1, 1, 1] + [8, 0, 0], views[5].image_points)
    found = fit(wrong, size)
    assert set(found.cut_views) == {2, 5}
    assert found.cut_views[5] == "mirrored"
    assert not found.used[2].any()
    # they are reported as what their best pose leaves, not as where the fit happened to leave them
    assert found.view_errors.max() < size[0] / 2
    rest = fit([v for i, v in enumerate(views) if i not in (2, 5)], size)
    assert synthetic.projection_error(rest.camera, found.camera).mean() < 0.02
