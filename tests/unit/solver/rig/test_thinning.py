"""Thinned moments: their number of points is bounded, they cover the board, and the rig stays the same."""

import numpy as np
import pytest

from calibsolver import Board, View, rig
from calibsolver.rig.problem import MIN_KEPT_POINTS, thin, thin_view
from tests.helpers.solver import rigs, synthetic

DENSE = Board((50, 49), dictionary="DICT_APRILTAG_36h10")


def view_of(board: Board) -> View:
    """View of a whole board; the pixels do not matter."""
    return View(board.points, board.points[:, :2] * 10)


def test_one_dense_view_among_many_costs_no_more_than_its_share() -> None:
    sparse = View(DENSE.points[:100], DENSE.points[:100, :2] * 10)
    moments = [{i: view_of(DENSE) if m == 0 else sparse for i in range(8)} for m in range(100)]
    thinned = thin(moments, rig.MAX_ONLINE_POINTS)
    longest = max(len(view) for moment in thinned for view in moment.values())
    assert longest * 8 * 100 <= rig.MAX_ONLINE_POINTS
    assert longest >= MIN_KEPT_POINTS


def test_few_views_stay_themselves() -> None:
    moments = [{i: view_of(Board((9, 6))) for i in range(8)} for _ in range(24)]
    thinned = thin(moments, rig.MAX_ONLINE_POINTS)
    assert all(a[i] is b[i] for a, b in zip(moments, thinned, strict=True) for i in a)


@pytest.mark.parametrize("squares", [(50, 49), (24, 18), (14, 9), (18, 18), (9, 33)])
def test_points_kept_are_from_all_over_the_board(squares: tuple[int, int]) -> None:
    board = Board(squares, dictionary="DICT_APRILTAG_36h10")
    kept = thin_view(view_of(board), MIN_KEPT_POINTS)
    assert len(kept) == MIN_KEPT_POINTS
    spread = np.linalg.svd(kept.object_points[:, :2] - kept.object_points[:, :2].mean(axis=0))[1]
    whole = np.linalg.svd(board.points[:, :2] - board.points[:, :2].mean(axis=0))[1]
    share = spread / whole * np.sqrt(len(board.points) / MIN_KEPT_POINTS)
    assert (share > 0.75).all()


def test_thinned_rig_is_the_rig_within_its_stated_error() -> None:
    rng = np.random.default_rng(3)
    flat = synthetic.rectilinear_cameras(12)
    truth = rigs.side_by_side([flat[0], flat[5]], 2.0)
    moments = rigs.moments(truth, Board((24, 18), dictionary="DICT_4X4_250"), 10, 0.2, rng)
    found = rig.fit(moments, [(camera.img_size, camera.model) for camera in truth.cameras], max_points=1000)
    assert sum(len(view) for moment in moments for view in moment.values()) > 4000
    std = np.sqrt(np.diagonal(found.pose_covariance(1)))
    assert (np.abs(found.poses[1] - truth.motions[1].vector()) < 4 * std).all()
    assert found.uncertainty.rms < 1.0
