"""Location of contributors: equal weights and bounded influence."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from calibsolver import Camera, fit
from calibsolver.consensus import Member, Rule, difference, pool
from calibsolver.consensus.location import MAX_VIEW_POINTS, Contributions, FittedMember, thin
from tests.helpers.marks import thorough
from tests.helpers.solver import populations, synthetic, worlds

CAMERA = synthetic.rectilinear_cameras()[6]
SIZE = CAMERA.img_size
RULE = Rule(min_contributors=3)
MOVED = 1.0
"""px over the image, by which no two contributors may move a reliable answer."""


def scaled(factor: float) -> Camera:
    k = CAMERA.intrinsics
    k[:2] *= factor
    return Camera.from_intrinsics(CAMERA.model, k, SIZE)


@cache
def fitted(camera: Camera, contributor: str, seed: int, corners: int = 40) -> FittedMember:
    rng = np.random.default_rng(seed)
    board = worlds.draw_board(rng, corners)
    views = tuple(populations.views(camera, rng, 0.05, 6, board=board))
    return FittedMember(Member(f"{contributor}{seed}", contributor, views), fit(views, SIZE))


@pytest.fixture(scope="module")
def honest() -> list[FittedMember]:
    """Specimens 0.1 % apart, the last three of one contributor."""
    factors = (0.999, 1.001, 1.0, 1.001, 1.002)
    return [fitted(scaled(f), "abccc"[i], i) for i, f in enumerate(factors)]


def test_location_is_the_mean_of_contributors(honest: list[FittedMember]) -> None:
    found = Contributions(honest, CAMERA).relinearize(range(5))
    location = found.locate(range(5))
    assert location.weights.min() > 0.8
    assert difference(found.camera_at(location), scaled(1 + (-0.001 + 0.001 + 0.001) / 3)) < 0.1


def test_names_of_contributors_change_nothing(honest: list[FittedMember]) -> None:
    renamed = [
        replace(f, member=replace(f.member, contributor={"a": "z", "b": "y", "c": "x"}[f.member.contributor]))
        for f in honest
    ]
    locations = [Contributions(each, CAMERA).locate(range(5)).y for each in (honest, renamed)]
    assert locations[0].tobytes() == locations[1].tobytes()


@pytest.mark.parametrize(
    ("lie", "corners"), [(1.02, 2401), (1.3, 40), *thorough((1.005, 40), (1.02, 40), (1.05, 6))]
)
def test_liar_however_far_or_dense_pulls_no_harder(lie: float, corners: int) -> None:
    members = [fitted(CAMERA, f"h{i}", i) for i in range(5)]
    members += [fitted(scaled(lie), f"l{i}", 5 + i, corners) for i in range(2)]
    found = Contributions(members, members[0].calibration.camera).relinearize(range(7))
    alone = found.locate(range(5)).y
    assert found.length(found.locate(range(6)).y - alone) < 0.25
    assert found.length(found.locate(range(7)).y - alone) < 0.5
    assert found.leave_out_influence(range(7), lambda rest: rest) < 0.5


def test_thinned_points_stand_for_all() -> None:
    view = fitted(CAMERA, "dense", 0, corners=2401).member.views[0]
    thinned, share = thin(view, np.ones(len(view), dtype=bool))
    assert len(thinned) == MAX_VIEW_POINTS < len(view)
    assert share == pytest.approx(len(view) / MAX_VIEW_POINTS)


@pytest.mark.parametrize(
    ("number", "corners"), [(4, 2401), *thorough((0, None), (1, None), (2, None), (3, None))]
)
def test_liars_in_honest_worlds_move_no_reliable_answer(number: int, corners: int | None) -> None:
    rng = np.random.default_rng((19, number))
    product = worlds.world(rng)
    honest = [worlds.member(f"h{i}", worlds.specimen(product, rng), rng) for i in range(5)]
    before = pool(honest, SIZE, "rectilinear", RULE)
    false = worlds.lie(product.camera, ("focal", "distortion")[number % 2], rng)
    liars = [worlds.member(f"l{i}", false, rng, corners) for i in range(2)]
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
