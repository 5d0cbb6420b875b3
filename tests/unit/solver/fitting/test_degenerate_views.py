"""Views whose points lie on a line: set aside with a reason, the others fitted as if they were alone."""

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
    """The first corners of the view that lie on one line of the board."""
    on_line = np.flatnonzero(view.object_points[:, 1] == view.object_points[0, 1])[:count]
    return View(view.object_points[on_line], view.image_points[on_line])


@pytest.fixture(scope="module")
def real() -> tuple[list[View], tuple[int, int]]:
    return corner_views("opencv_left")


@pytest.mark.parametrize("model", ["rectilinear", "fisheye"])
def test_view_of_one_row_is_set_aside(real: tuple[list[View], tuple[int, int]], model: str) -> None:
    views, size = real
    alone = fit(views, size, model)
    found = fit([*views[:3], row_of_corners(views[2]), *views[3:]], size, model)
    assert found.cut_views == {3: "degenerate", **{i + (i >= 3): r for i, r in alone.cut_views.items()}}
    np.testing.assert_array_equal(found.camera.intrinsics, alone.camera.intrinsics)
    np.testing.assert_array_equal(found.covariance, alone.covariance)
    np.testing.assert_array_equal(np.delete(found.poses, 3, axis=0), alone.poses)
    assert not found.used[3].any()
    assert found.residuals[3].shape == (6, 2)
    assert np.isnan(found.poses[3]).all()  # a line has no pose, and so no error that could count
    assert found.avg_reprojection_error == alone.avg_reprojection_error


def test_view_in_one_place_is_set_aside_and_described(real: tuple[list[View], tuple[int, int]]) -> None:
    views, size = real
    place = View(views[0].object_points, np.full_like(views[0].image_points, 300.0))
    found = fit([place, *views], size)
    assert found.cut_views[0] == "degenerate"
    assert found.uncertainty() == fit(views, size).uncertainty()
    described = describe(found, [place, *views])
    json.dumps(described, allow_nan=False)
    shown = described["views"]
    assert isinstance(shown, list)
    assert isinstance(shown[0], dict)
    assert (shown[0]["reason"], shown[0]["rms"]) == ("degenerate", None)


def test_degenerate_views_alone_raise(real: tuple[list[View], tuple[int, int]]) -> None:
    views, size = real
    rows = [row_of_corners(view) for view in views[:4]]
    with pytest.raises(CalibrationError) as caught:
        fit(rows, size)
    assert caught.value.code == "degenerate"


def test_least_squares_leaves_no_view_out(real: tuple[list[View], tuple[int, int]]) -> None:
    views, size = real
    with pytest.raises(CalibrationError) as caught:
        fit([*views, row_of_corners(views[0])], size, robust=False)
    assert caught.value.code == "degenerate"


def test_refine_sets_the_view_aside(real: tuple[list[View], tuple[int, int]]) -> None:
    views, size = real
    known = fit(views, size)
    poses = np.concatenate([known.poses, np.full((1, 6), np.nan)])
    found = refine([*views, row_of_corners(views[0])], known.camera, poses)
    alone = refine(views, known.camera, known.poses)
    assert found.cut_views[len(views)] == "degenerate"
    np.testing.assert_array_equal(found.camera.intrinsics, alone.camera.intrinsics)


def test_cross_validation_never_leaves_the_view_out(real: tuple[list[View], tuple[int, int]]) -> None:
    views, size = real
    place = View(views[0].object_points, np.full_like(views[0].image_points, 300.0))
    found = held_out([*views, place], size)
    assert found.rms == held_out(views, size).rms
    assert np.isnan(found.view_errors[-1])


def test_consensus_sets_the_view_aside(real: tuple[list[View], tuple[int, int]]) -> None:
    views, size = real
    place = View(views[0].object_points, np.full_like(views[0].image_points, 300.0))
    halves = [tuple(views[::2]), tuple(views[1::2])]
    clean = pool([Member(str(i), str(i), v) for i, v in enumerate(halves)], size, "rectilinear")
    found = pool(
        [Member(str(i), str(i), (row_of_corners(v[0]), *v, place)) for i, v in enumerate(halves)],
        size,
        "rectilinear",
    )
    assert found.members == clean.members
    assert not found.dropped
    assert found.held_out_error == clean.held_out_error
    np.testing.assert_array_equal(found.calibration.camera.intrinsics, clean.calibration.camera.intrinsics)
