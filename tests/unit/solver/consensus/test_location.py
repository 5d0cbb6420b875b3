"""Location of contributors: equal weights and bounded influence."""

from functools import cache

import numpy as np
import pytest

from calibsolver import Board, Camera, fit
from calibsolver.consensus import Member, Rule, difference, pool
from calibsolver.consensus.location import MAX_VIEW_POINTS, Contributions, FittedMember, thin
from tests.helpers.marks import thorough
from tests.helpers.solver import attacks, populations, synthetic

CAMERA = synthetic.rectilinear_cameras()[6]
SIZE = CAMERA.img_size
RULE = Rule(min_contributors=3)
DENSE = Board((50, 50), dictionary="DICT_APRILTAG_36h10")
CARE = (
    (Board((4, 4)), 0.1, 12),
    (Board((6, 5)), 0.6, 5),
    (Board((14, 9), dictionary="DICT_4X4_100"), 0.3, 4),
    (Board(), 0.2, 8),
    (DENSE, 0.4, 4),
)
"""Boards of contributors, noise of their corners, px, and numbers of views."""
MOVED = 1.0
"""px over the image, by which no two contributors may move a reliable answer."""


@cache
def fitted(camera: Camera, name: str, seed: int, board: Board = populations.BOARD) -> FittedMember:
    rng = np.random.default_rng(seed)
    member = populations.member(name, camera, rng, noise=0.05, board=board)
    return FittedMember(member, fit(member.views, SIZE))


@pytest.mark.parametrize(
    ("lie", "board"),
    [(1.02, DENSE), (1.3, Board()), *thorough((1.005, Board()), (1.02, Board()), (1.05, Board((4, 3))))],
)
def test_liar_however_far_or_dense_pulls_no_harder(lie: float, board: Board) -> None:
    members = [fitted(CAMERA, f"h{i}", i) for i in range(5)]
    members += [fitted(synthetic.zoomed(CAMERA, lie), f"l{i}", 5 + i, board) for i in range(2)]
    found = Contributions(members, members[0].calibration.camera).relinearize(range(7))
    alone = found.locate(range(5)).y
    assert found.length(found.locate(range(6)).y - alone) < 0.25
    assert found.length(found.locate(range(7)).y - alone) < 0.5
    assert found.leave_out_influence(range(7), lambda rest: rest) < 0.5


def test_thinned_points_stand_for_all() -> None:
    view = fitted(CAMERA, "dense", 0, DENSE).member.views[0]
    thinned, share = thin(view, np.ones(len(view), dtype=bool))
    assert len(thinned) == MAX_VIEW_POINTS < len(view)
    assert share == pytest.approx(len(view) / MAX_VIEW_POINTS)


@pytest.mark.parametrize(("lie", "board"), [(1.005, DENSE), *thorough((0.994, DENSE), (1.007, Board()))])
def test_liars_among_different_specimens_move_no_reliable_answer(lie: float, board: Board) -> None:
    rng = np.random.default_rng(19)
    honest = [
        populations.member(
            f"h{i}", attacks.vary(CAMERA, 0.003, rng), rng, board=own, noise=noise, count=count
        )
        for i, (own, noise, count) in enumerate(CARE)
    ]
    false = synthetic.zoomed(CAMERA, lie)
    liars = [populations.member(f"l{i}", false, rng, noise=0.05, board=board) for i in range(2)]
    before = pool(honest, SIZE, "rectilinear", RULE)
    for count in (1, 2):
        after = pool([*honest, *liars[:count]], SIZE, "rectilinear", RULE)
        moved = difference(before.calibration.camera, after.calibration.camera)
        assert moved < MOVED or not after.reliable
        assert after.calibration.uncertainty().rms > 0.8 * before.calibration.uncertainty().rms


def test_contributors_of_two_families_count_by_the_larger() -> None:
    rng = np.random.default_rng(2)
    families = ("ipv4", "ipv4", "ipv4", "ipv6", "ipv6")
    members = [
        Member(str(i), str(i), tuple(populations.views(CAMERA, rng, count=4)), family)
        for i, family in enumerate(families)
    ]
    found = pool(members, SIZE, "rectilinear", RULE)
    assert (found.contributors, found.reliable) == (3, True)
    assert pool(members, SIZE, "rectilinear", Rule(min_contributors=4)).reason == "few_contributors"
