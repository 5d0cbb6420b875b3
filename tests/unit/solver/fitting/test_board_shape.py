"""Shape of the board."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from calibsolver import Camera, View, fit, image_transform
from calibsolver.fitting.board_shape import MAX_STRETCH, BoardShape
from calibsolver.fitting.fit import MIN_SHAPE_VIEWS
from calibsolver.quality import held_out
from tests.helpers.data import corner_views, external_data
from tests.helpers.marks import corner_sets, thorough
from tests.helpers.solver import hands, populations, synthetic

CAMERA = synthetic.rectilinear_cameras()[5]


@cache
def captured(hand: hands.Hand, views: int = 15) -> list[View]:
    return populations.views(CAMERA, np.random.default_rng(1), count=views, hand=hand)


def stretched(share: float, hand: hands.Hand, views: int = 15) -> list[View]:
    return [View(v.object_points * (share, 1, 1), v.image_points) for v in captured(hand, views)]


def test_bend_is_recovered_and_no_longer_spoils_the_camera() -> None:
    views = captured(hands.BENT)
    found = fit(views, CAMERA.img_size)
    flat = fit(views, CAMERA.img_size, board_shape=False)
    shape = found.board_shape
    assert shape is not None
    assert 0.002 < shape.sag < 0.008  # 0.5 % over its mean
    assert shape.sag_std < 0.1 * shape.sag
    assert shape.stretch < 0.001
    assert shape.stretch < 3 * shape.stretch_std
    before = synthetic.projection_error(CAMERA, flat.camera).mean()
    after = synthetic.projection_error(CAMERA, found.camera).mean()
    assert after < 0.25 * before  # 0.37 px instead of 1.81
    assert found.noise == pytest.approx(0.2, rel=0.1)
    assert held_out(views, CAMERA.img_size).rms < 0.4 * flat.avg_reprojection_error


@pytest.mark.parametrize(
    "views",
    [
        pytest.param(captured(hands.STEADY), id="flat"),
        pytest.param([replace(view, flat=True) for view in captured(hands.BENT)], id="on a screen"),
        pytest.param(captured(hands.BENT)[: MIN_SHAPE_VIEWS - 1], id="few views"),
    ],
)
def test_board_stays_as_drawn(views: list[View]) -> None:
    found = fit(views, CAMERA.img_size)
    flat = fit(views, CAMERA.img_size, board_shape=False)
    assert found.board_shape is None
    np.testing.assert_array_equal(found.camera.intrinsics, flat.camera.intrinsics)
    np.testing.assert_array_equal(found.covariance, flat.covariance)


def test_views_that_are_thinned_or_turned_stay_flat() -> None:
    view = replace(captured(hands.BENT)[0], flat=True)
    assert view.subset(np.arange(10)).flat
    assert image_transform.rotate(CAMERA.img_size, 90).view(view).flat


def test_stretch_of_the_print_is_recovered() -> None:
    shape = fit(stretched(1.005, hands.STEADY), CAMERA.img_size).board_shape
    assert shape is not None
    assert shape.stretch == pytest.approx(0.005, rel=0.2)
    assert shape.stretch == pytest.approx(0.005, abs=3 * shape.stretch_std)


def test_stretch_that_no_printer_causes_is_left_to_the_camera() -> None:
    views = stretched(1.03, hands.BENT)
    found = fit(views, CAMERA.img_size)
    flat = fit(views, CAMERA.img_size, board_shape=False)
    shape = found.board_shape
    assert shape is not None
    assert 0.002 < shape.sag < 0.012
    assert shape.stretch < 0.005
    assert found.avg_reprojection_error < 0.9 * flat.avg_reprojection_error


@pytest.mark.parametrize("count", [3, 15])
def test_stretch_beyond_the_limit_is_never_believed(count: int) -> None:
    for stretch in (1.012, 1.02, 1.05):
        shape = fit(stretched(stretch, hands.STEADY, count), CAMERA.img_size).board_shape
        assert shape is None or shape.stretch <= MAX_STRETCH


def test_pixels_that_are_not_square_are_no_stretch_of_the_board() -> None:
    k = CAMERA.intrinsics * (1, 1.03, *[1] * 7)
    camera = Camera.from_intrinsics(CAMERA.model, k, CAMERA.img_size)
    found = fit(populations.views(camera, np.random.default_rng(0)), camera.img_size)
    assert found.board_shape is None or found.board_shape.stretch <= MAX_STRETCH
    assert found.camera.focal[1] == pytest.approx(k[1], rel=0.003)


@pytest.mark.parametrize(
    "name", [*corner_sets(["jy_left", "derlunz", "opencv_right"]), *thorough("babel_ov_plane")]
)
def test_real_boards_are_predicted_better_in_their_shape(name: str) -> None:
    views, size = corner_views(name)
    kept = [
        view.subset(used)
        for view, used in zip(views, fit(views, size, "fisheye").used, strict=True)
        if used.sum() >= 6
    ]
    shaped, drawn = (held_out(kept, size, "fisheye", board_shape=shape).rms for shape in (True, False))
    assert shaped < 0.98 * drawn


@pytest.mark.parametrize("model", ["rectilinear", "fisheye"])
def test_one_real_board_has_one_shape(model: str) -> None:
    views, size = corner_views("jy_left")
    shapes = [fit(half, size, model).board_shape for half in (views[::2], views[1::2])]
    one, other = (np.array(shape.parameters[:3]) for shape in shapes if shape)
    assert np.abs(one - other).max() < 0.6 * np.abs(one + other).max() / 2


def test_shape_moves_points_by_its_parameters() -> None:
    view = captured(hands.STEADY, 1)[0]
    shape = BoardShape((4.5, 3.0), 4.0, (1.0, 0.6), (0.01, 0.0, 0.0, 0.001, 0.0))
    moved = shape.apply(view).object_points - view.object_points
    x, y = ((view.object_points[:, :2] - (4.5, 3.0)) / 4.0).T
    np.testing.assert_allclose(moved, np.stack([0.004 * x, -0.004 * y, 0.08 * x * x], axis=1), atol=1e-12)


@external_data
def test_shape_leaves_pixels_square() -> None:
    views, size = corner_views("pv_charuco_1280")
    fx, fy = fit(views, size).camera.focal
    assert fx == pytest.approx(fy, rel=0.004)
