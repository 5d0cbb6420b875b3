"""Contributors of one camera: who agrees, and how far anyone may move the answer."""

from functools import cache
from itertools import product

import numpy as np
import pytest

from calibsolver import Board, Camera, fit
from calibsolver.consensus import Member, Rule, difference, pool
from calibsolver.consensus.location import MAX_VIEW_POINTS, Contributions, FittedMember, thin
from tests.helpers.data import external_data
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


@pytest.mark.parametrize(
    ("kind", "effort"),
    [
        ("focal", attacks.Effort(5)),
        ("focal", attacks.EFFORTS["very poor views"]),
        ("shift", attacks.Effort(30, 0.05)),
        *thorough(("junk", attacks.Effort(1)), ("shift", attacks.Effort(5)), ("each", attacks.Effort(5))),
        *thorough(*product(("focal", "shift"), attacks.EFFORTS.values())),
    ],
)
def test_lying_minority_does_not_move_the_consensus(kind: str, effort: attacks.Effort) -> None:
    """By half a pixel over the image, from just beside the truth to 30 % off, whatever errors it states."""
    found = attacks.trial(np.random.default_rng(5), kind, 10, effort=effort)
    assert not found.wrong, found.moved
    assert found.reliable  # six are honest


def test_honest_contributors_of_poor_views_weigh_little() -> None:
    rng = np.random.default_rng(4)
    precise = [populations.member(f"p{i}", CAMERA, rng) for i in range(5)]
    poor = [populations.member(f"v{i}", CAMERA, rng, noise=2.0, count=3) for i in range(2)]
    before, after = (pool(group, SIZE, "rectilinear", RULE) for group in (precise, [*precise, *poor]))
    assert before.reliable
    assert after.reliable
    assert set(after.members) >= {member.id for member in precise}
    worst = max(difference(CAMERA, fit(m.views, SIZE).camera) for m in poor)
    assert worst > 2
    assert difference(before.calibration.camera, after.calibration.camera) < worst / 10


def test_consensus_that_states_too_much_is_imprecise() -> None:
    camera, rng = synthetic.rectilinear_cameras()[5], np.random.default_rng(4)
    members = [populations.member(str(i), camera, rng, noise=3.0, count=3) for i in range(5)]
    pooled = pool(members, SIZE, "rectilinear", RULE)
    assert len(pooled.members) == 5
    assert pooled.coverage.rms > 1.5
    assert pooled.coverage.share > 0.5
    assert (pooled.reliable, pooled.reason) == (False, "imprecise")


@external_data
@pytest.mark.parametrize(
    ("lens", "outside"),
    [("RF16mm F2.8 STM 16.00mm", 1), *thorough(("EF-S10-18mm f/4.5-5.6 IS STM 10.00mm", 0))],
)
def test_lens_profiles_agree_within_a_mode(lens: str, outside: int) -> None:
    """Six profiles whose lens and setting are named; one states a focal length 2.2 % below the others'."""
    profiles = populations.profiles()
    found = next(v for mode, v in profiles.items() if mode[2] == lens and mode[3] and len(v) == 6)
    pooled = pool(populations.members(found, np.random.default_rng(0)), found[0][0].img_size, "fisheye")
    assert (pooled.reliable, len(pooled.members)) == (True, 6 - outside)


@external_data
def test_profiles_of_five_lenses_do_not_agree() -> None:
    rng = np.random.default_rng(0)
    modes = populations.profiles().items()
    lenses = [v for mode, v in modes if mode[1] == "KOMODO 6K" and mode[2] and mode[4] == "5760"]
    drawn = [lenses[i][0] for i in rng.choice(len(lenses), 5, replace=False)]
    assert not pool(populations.members(drawn, rng), drawn[0][0].img_size, "fisheye").reliable
