"""Shape of the board: recovered where it is bent, left alone where it is flat, and helpful on real boards."""

import numpy as np
import pytest

from calibsolver import View, fit
from calibsolver.fitting.board_shape import BoardShape, estimate_board_shape
from calibsolver.quality.board_flatness import MIN_SHAPE_VIEWS, fit_with_board_shape
from tests.helpers.data import available, corner_views, external_data
from tests.helpers.solver import hands, peers, synthetic

CAMERA = synthetic.rectilinear_cameras()[5]


def captured(hand: hands.Hand, views: int = 15) -> list[View]:
    return peers.random_poses(CAMERA, np.random.default_rng(1), views, 0.2, hand).views


def test_bend_is_recovered_and_no_longer_spoils_the_camera() -> None:
    views = captured(hands.BENT)
    found = fit_with_board_shape(views, CAMERA.img_size)
    assert found.used
    assert found.reported
    assert found.shape is not None
    assert 0.002 < found.shape.sag < 0.008  # 0.5 % over its mean
    assert found.shape.stretch < 0.001
    flat = fit(views, CAMERA.img_size)
    before = synthetic.projection_error(CAMERA, flat.camera).mean()
    after = synthetic.projection_error(CAMERA, found.calibration.camera).mean()
    assert after < 0.4 * before  # 0.47 px instead of 1.81
    assert found.calibration.noise == pytest.approx(0.2, rel=0.1)
    assert found.held_out_shaped < 0.3 * found.held_out


def test_flat_board_stays_as_drawn() -> None:
    views = captured(hands.STEADY)
    found = fit_with_board_shape(views, CAMERA.img_size)
    assert not found.reported
    assert found.shape is not None
    assert max(found.shape.sag, found.shape.stretch) < 0.001
    assert found.held_out_shaped == pytest.approx(found.held_out, rel=0.01)


def test_stretch_of_the_print_is_recovered() -> None:
    drawn = captured(hands.STEADY)
    views = [View(v.object_points * (1.005, 1, 1), v.image_points) for v in drawn]
    found = fit_with_board_shape(views, CAMERA.img_size)
    assert found.shape is not None
    assert found.shape.stretch == pytest.approx(0.005, rel=0.2)
    assert found.used


def test_few_views_tell_no_shape() -> None:
    found = fit_with_board_shape(captured(hands.BENT)[: MIN_SHAPE_VIEWS - 1], CAMERA.img_size)
    assert (found.shape, found.used, found.reported) == (None, False, False)


@pytest.mark.parametrize("name", available(["jy_left", "derlunz", "opencv_right", "babel_ov_plane"]))
def test_real_boards_are_predicted_better_in_their_shape(name: str) -> None:
    views, size = corner_views(name)
    found = fit_with_board_shape(views, size, "fisheye")
    assert found.used
    assert found.held_out_shaped < 0.98 * found.held_out


@pytest.mark.parametrize("model", ["rectilinear", "fisheye"])
def test_one_real_board_has_one_shape(model: str) -> None:
    """Two halves of a set, fitted by themselves, tell the same bend."""
    views, size = corner_views("jy_left")
    shapes = []
    for half in (views[::2], views[1::2]):
        shape, _ = estimate_board_shape(half, fit(half, size, model))
        shapes.append(np.array(shape.parameters))
    difference = np.abs(shapes[0] - shapes[1])
    assert difference.max() < 0.6 * np.abs(shapes[0] + shapes[1]).max() / 2


def test_shape_moves_points_by_its_parameters() -> None:
    view = captured(hands.STEADY, 1)[0]
    shape = BoardShape((4.5, 3.0), 4.0, (1.0, 0.6), (0.01, 0.0, 0.0, 0.001, 0.0))
    moved = shape.apply(view).object_points - view.object_points
    x, y = ((view.object_points[:, :2] - (4.5, 3.0)) / 4.0).T
    np.testing.assert_allclose(moved, np.stack([0.004 * x, -0.004 * y, 0.08 * x * x], axis=1), atol=1e-12)


@external_data
def test_shape_that_makes_pixels_less_square_is_not_used() -> None:
    """On these photographs of a webcam a stretch of 0.4 % predicts 1.6 % better, and moves fx by 1 %."""
    views, size = corner_views("pv_charuco_1280")
    found = fit_with_board_shape(views, size)
    assert found.held_out_shaped < 0.99 * found.held_out
    assert not found.used
    fx, fy = found.calibration.camera.focal
    assert fx == pytest.approx(fy, rel=0.001)
