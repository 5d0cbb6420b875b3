"""Bad measurements on real corner sets leave no trace; views on a line are set aside."""

import json

import numpy as np
import pytest

from calibsolver import CalibrationError, View, fit
from calibsolver.consensus.pooling import Member, pool
from calibsolver.fitting.fit import refine
from calibsolver.quality.cross_validation import held_out
from calibsolver.quality.report import describe
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


def row_of_corners(view: View, count: int = 6) -> View:
    on_line = np.flatnonzero(view.object_points[:, 1] == view.object_points[0, 1])[:count]
    return View(view.object_points[on_line], view.image_points[on_line])


VIEWS, SIZE = corner_views("opencv_left")
PLACE = View(VIEWS[0].object_points, np.full_like(VIEWS[0].image_points, 300.0))
"""All corners in one place."""


@pytest.mark.parametrize("model", ["rectilinear", "fisheye"])
def test_view_of_one_row_is_set_aside(model: str) -> None:
    alone = fit(VIEWS, SIZE, model)
    found = fit([*VIEWS[:3], row_of_corners(VIEWS[2]), *VIEWS[3:]], SIZE, model)
    assert found.cut_views == {3: "degenerate", **{i + (i >= 3): r for i, r in alone.cut_views.items()}}
    np.testing.assert_array_equal(found.camera.intrinsics, alone.camera.intrinsics)
    np.testing.assert_array_equal(found.covariance, alone.covariance)
    np.testing.assert_array_equal(np.delete(found.poses, 3, axis=0), alone.poses)
    assert not found.used[3].any()
    assert found.residuals[3].shape == (6, 2)
    assert np.isnan(found.poses[3]).all()  # a line has no pose, and so no error that could count
    assert found.avg_reprojection_error == alone.avg_reprojection_error


def test_view_in_one_place_is_set_aside_and_described() -> None:
    found = fit([PLACE, *VIEWS], SIZE)
    described = describe(found, [PLACE, *VIEWS])
    json.dumps(described, allow_nan=False)
    first = described["views"][0]  # type: ignore[index]
    assert (first["reason"], first["rms"]) == ("degenerate", None)


@pytest.mark.parametrize(
    ("views", "robust"),
    [([row_of_corners(view) for view in VIEWS[:4]], True), ([*VIEWS, row_of_corners(VIEWS[0])], False)],
    ids=["degenerate views alone", "least squares"],
)
def test_views_that_may_not_be_set_aside_raise(views: list[View], robust: bool) -> None:
    with pytest.raises(CalibrationError) as caught:
        fit(views, SIZE, robust=robust)
    assert caught.value.code == "degenerate"


def test_refine_sets_the_view_aside() -> None:
    known = fit(VIEWS, SIZE)
    poses = np.concatenate([known.poses, np.full((1, 6), np.nan)])
    found = refine([*VIEWS, row_of_corners(VIEWS[0])], known.camera, poses)
    alone = refine(VIEWS, known.camera, known.poses)
    assert found.cut_views[len(VIEWS)] == "degenerate"
    np.testing.assert_array_equal(found.camera.intrinsics, alone.camera.intrinsics)


def test_cross_validation_never_leaves_the_view_out() -> None:
    found = held_out([*VIEWS, PLACE], SIZE)
    assert found.rms == held_out(VIEWS, SIZE).rms
    assert np.isnan(found.view_errors[-1])


def test_consensus_sets_the_view_aside() -> None:
    halves = [tuple(VIEWS[::2]), tuple(VIEWS[1::2])]
    more = [(row_of_corners(views[0]), *views, PLACE) for views in halves]
    clean, found = (
        pool([Member(str(i), str(i), views) for i, views in enumerate(each)], SIZE, "rectilinear")
        for each in (halves, more)
    )
    assert found.members == clean.members
    assert not found.dropped
    assert found.held_out_error == clean.held_out_error
    np.testing.assert_array_equal(found.calibration.camera.intrinsics, clean.calibration.camera.intrinsics)
