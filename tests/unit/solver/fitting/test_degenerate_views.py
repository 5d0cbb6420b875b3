"""Views whose points lie on a line are set aside."""

import json

import numpy as np
import pytest

from calibsolver import CalibrationError, View, fit
from calibsolver.consensus.pooling import Member, pool
from calibsolver.fitting.fit import refine
from calibsolver.quality.cross_validation import held_out
from calibsolver.quality.report import describe
from tests.helpers.data import corner_views


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
