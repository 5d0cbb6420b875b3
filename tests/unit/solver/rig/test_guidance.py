"""Guidance of rigs: captures that end, targets that several cameras see, and what links cameras."""

import numpy as np
import pytest

from calibsolver import Board, rig
from tests.bench import rigs as bench
from tests.helpers.marks import thorough
from tests.helpers.solver import rigs, synthetic

BOARD = Board((9, 6))


@pytest.mark.parametrize("seeds", [1, *thorough(3)])
def test_guided_captures_of_two_webcams_end_after_a_few_moments(seeds: int) -> None:
    """At 6 to 60 cm; 200 captures are in the benchmark."""
    taken = []
    for seed in range(seeds):
        rng = np.random.default_rng(1000 + seed)
        taken.append(bench.capture(bench.webcams(rng), rng))
    moments, predicted, errors = np.array(taken).T
    assert np.median(moments) <= 8
    assert moments.max() <= bench.MAX_MOMENTS, "none is stuck"
    assert (predicted <= bench.GOAL).all()
    assert np.median(errors) < bench.GOAL


def test_the_first_target_is_whole_and_says_who_is_not_linked() -> None:
    cameras = [((1280, 720), "rectilinear"), ((640, 480), "fisheye"), ((640, 480), "rectilinear")]
    target = rig.next_moment(BOARD, cameras, [], None)
    assert target.pose is None
    assert target.unlinked == (1, 2)
    (view,) = target.views.values()
    assert len(view.ids) == BOARD.corner_count


def test_targets_of_known_lenses_are_seen_by_both_and_skipped_ones_do_not_return() -> None:
    """Intrinsics that are held leave poses that both cameras see as the only ones that tell anything."""
    truth = rigs.side_by_side(synthetic.rectilinear_cameras(2), 2.0)
    moments = rigs.moments(truth, BOARD, 3, 0.2, np.random.default_rng(2))
    found = rig.fit(moments, truth.cameras)
    target = rig.next_moment(BOARD, truth.cameras, moments, found)
    assert set(target.views) == {0, 1}
    assert min(len(view.ids) for view in target.views.values()) >= 0.3 * BOARD.corner_count
    assert target.pose is not None
    other = rig.next_moment(BOARD, truth.cameras, moments, found, [target.pose])
    assert other.pose is not None
    assert np.linalg.norm(other.pose - target.pose) > 0.3
