"""Pooled consensus and its reliability, and the cache of members' fits."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from calibsolver import Calibration, CalibrationError, Camera, View, fit
from calibsolver.consensus import fit_memory
from calibsolver.consensus.agreement import difference
from calibsolver.consensus.pooling import Consensus, Member, Rule, pool
from calibsolver.image_transform import resize
from tests.helpers.data import corner_views, external_data
from tests.helpers.marks import corner_sets, thorough
from tests.helpers.solver import attacks, hands, populations, synthetic

SIZE = (1280, 720)
CAMERA = synthetic.rectilinear_cameras()[6]


def member(seed: int, focal: float = 1.0, contributor: str | None = None) -> Member:
    """Calibration of a specimen of one product."""
    specimen = attacks.vary(synthetic.zoomed(CAMERA, focal), 0.003, np.random.default_rng(seed))
    views = populations.views(specimen, np.random.default_rng(seed), count=4)
    return Member(f"m{seed}", contributor or f"c{seed}", tuple(views))


def members_of(cameras: Sequence[Camera], **options: Any) -> list[Member]:
    rng = np.random.default_rng(0)
    return [populations.member(str(i), camera, rng, **options) for i, camera in enumerate(cameras)]


def assert_same_camera(one: Consensus, other: Consensus) -> None:
    np.testing.assert_array_equal(one.calibration.camera.intrinsics, other.calibration.camera.intrinsics)


@pytest.fixture(scope="module")
def honest() -> list[Member]:
    return [member(seed) for seed in range(7)]


def test_consensus_is_reliable_from_five_members(honest: list[Member]) -> None:
    five = pool(honest[:5], SIZE, "rectilinear")
    assert (five.reliable, five.total, five.contributors) == (True, 5, 5)
    assert five.members == ("m0", "m1", "m2", "m3", "m4")
    four = pool(honest[:4], SIZE, "rectilinear")
    assert (four.reliable, four.total) == (False, 4)
    assert five.calibration.camera.matrix[0, 0] == pytest.approx(CAMERA.matrix[0, 0], rel=0.01)


def test_too_few_contributors_are_not_reliable(honest: list[Member]) -> None:
    assert np.isnan(pool(honest[:1], SIZE, "rectilinear").spread)
    two = [Member(m.id, f"c{i % 2}", m.views) for i, m in enumerate(honest)]
    assert pool(two, SIZE, "rectilinear").reliable
    found = pool(two, SIZE, "rectilinear", Rule(min_contributors=3))
    assert (found.reliable, found.reason) == (False, "few_contributors")


@pytest.mark.parametrize("focal", [1.15, *thorough(1.03, 1.01)])
def test_returning_contributors_do_not_outvote_others(honest: list[Member], focal: float) -> None:
    returning = [member(90 + i, focal=focal, contributor=f"liar {i % 3}") for i in range(6)]
    points = honest[0].views[0].object_points[::3]
    scattered = View(points, np.random.default_rng(0).uniform(0, 700, (len(points), 2)))
    noise = Member("noise", "liar 0", (scattered,))
    rule = Rule(min_contributors=3)
    found = pool([*returning, *honest[:5], noise], SIZE, "rectilinear", rule)
    assert (found.total, set(found.dropped)) == (12, {"noise"})
    alone = pool(honest[:5], SIZE, "rectilinear", rule)
    assert (
        difference(found.calibration.camera, alone.calibration.camera) < 0.004 * SIZE[0] or not found.reliable
    )
    if focal > 1.1:  # what is nearer may pass for a specimen, where these differ by 0.3 %
        assert found.members == alone.members
        assert (found.contributors, found.reliable) == (5, alone.reliable)
        assert_same_camera(found, alone)


@pytest.mark.parametrize(("min_contributors", "mean"), [(3, 0.002 / 3), (1, 0.006 / 5)])
def test_contributors_weigh_equally_where_they_are_distinguished(min_contributors: int, mean: float) -> None:
    """Focal lengths a little off, the last three those of one contributor."""
    cameras = [synthetic.zoomed(CAMERA, 1 + off) for off in (-0.0005, 0.0005, 0.002, 0.002, 0.002)]
    members = [
        replace(member, contributor=contributor)
        for member, contributor in zip(members_of(cameras, noise=0.05), "abccc", strict=True)
    ]
    found = pool(members, SIZE, "rectilinear", Rule(min_contributors=min_contributors))
    assert difference(found.calibration.camera, synthetic.zoomed(CAMERA, 1 + mean)) < 0.1


def test_names_of_contributors_change_nothing(honest: list[Member]) -> None:
    rule = Rule(min_contributors=3)
    renamed = [replace(m, contributor=f"c{9 - i}") for i, m in enumerate(honest[:5])]
    assert_same_camera(*(pool(each, SIZE, "rectilinear", rule) for each in (honest[:5], renamed)))


def test_consensus_without_majority_is_not_reliable(honest: list[Member]) -> None:
    others = [member(60 + i, focal=1.2) for i in range(5)]
    split = pool([*honest[:5], *others], SIZE, "rectilinear")
    assert len(split.members) == 5
    assert not split.reliable


@pytest.mark.parametrize("model", ["omnidirectional", *thorough("fisheye", "rational")])
def test_other_models_pool_the_same_views(model: str) -> None:
    members = members_of([CAMERA] * 5)
    pooled = pool(members, SIZE, model)
    assert pooled.reliable
    assert pooled.held_out_error < 0.5
    told_apart = pool(members, SIZE, model, Rule(min_contributors=3))
    assert told_apart.reliable
    assert difference(told_apart.calibration.camera, pooled.calibration.camera) < 0.2


def test_difference_is_in_pixels_after_the_best_rotation() -> None:
    shifted = CAMERA.intrinsics
    shifted[0] *= 1.01
    shifted[2] += 8
    other = Camera.from_intrinsics("rectilinear", shifted, SIZE)
    error = synthetic.projection_error(CAMERA, other, (12, 9))
    # angles are turned together, not pixels
    assert difference(CAMERA, other) == pytest.approx(np.sqrt(np.mean(error**2)), rel=0.1)


MODELS = {"mint_isaw": "rectilinear", "jy_left": "fisheye", "babel_ov_plane": "omnidirectional"}


@pytest.mark.parametrize("name", [*corner_sets(["mint_isaw", "jy_left"]), *thorough("babel_ov_plane")])
def test_real_views_in_parts_pool_to_the_whole_fit(name: str) -> None:
    """One camera's photographs dealt out to five members, each with a board of its own shape."""
    views, size = corner_views(name)
    model = MODELS[name]
    parts = [views[i::5] for i in range(5)]
    pooled = pool([Member(str(i), "lab", tuple(part)) for i, part in enumerate(parts)], size, model)
    shaped = [view for part in parts for view in fit_memory.fit_once(part, size, model).shaped(part)]
    whole, drawn = (fit(each, size, model, board_shape=False) for each in (shaped, views))
    assert pooled.reliable
    assert difference(pooled.calibration.camera, whole.camera) < 0.02
    assert pooled.held_out_error < 1.03 * max(whole.avg_reprojection_error, drawn.avg_reprojection_error)
    assert max(pooled.member_errors.values()) < 1.7 * min(pooled.member_errors.values())
    assert pooled.spread < 0.003 * size[0]
    told_apart = [Member(str(i), str(i), tuple(part)) for i, part in enumerate(parts)]
    located = pool(told_apart, size, model, Rule(min_contributors=3))
    assert located.members == tuple("01234")
    assert located.calibration.uncertainty().rms < 6, "also at the rim of a fisheye's domain"


@external_data
def test_another_mode_of_a_real_camera_is_kept_out() -> None:
    """Pictures of 960 px, resized to the 640 px of five contributors."""
    views, size = corner_views("pv_picam_640")
    others, other_size = corner_views("pv_picam_960")
    rng = np.random.default_rng(0)
    order, drawn = rng.permutation(len(views)), rng.permutation(len(others))[:4]
    members = [Member(str(a), str(a), tuple(views[i] for i in order[4 * a : 4 * a + 4])) for a in range(5)]
    resized = [resize(other_size, size).view(others[i]) for i in drawn]
    found = pool([*members, Member("other mode", "5", tuple(resized))], size, "rectilinear")
    assert found.members == tuple("01234")


def test_contributors_with_bent_boards_agree_in_the_shape_of_each() -> None:
    """Boards bend by 0.5 % in any direction, six views each: 0.25 px off at most, within what is stated."""
    camera = synthetic.rectilinear_cameras()[0]
    members = members_of([camera] * 5, hand=hands.BENT)
    found = pool(members, SIZE, "rectilinear", Rule(min_contributors=3))
    error = synthetic.rms_error(camera, found.calibration.camera)
    assert found.reliable
    assert error < 0.25
    assert error < 2 * found.calibration.uncertainty().rms
    assert found.held_out_error < 0.35, "noise of 0.2 px per coordinate is 0.28"


def test_modes_one_percent_apart_are_separate_groups_in_any_order() -> None:
    members = members_of([CAMERA] * 6 + [synthetic.zoomed(CAMERA, 1.01)] * 3, count=5)
    pooled = pool(members, SIZE, "rectilinear")
    assert pooled.groups == (tuple("012345"), tuple("678"))
    assert pooled.reliable
    order = np.random.default_rng(2).permutation(9)
    shuffled = pool([members[i] for i in order], SIZE, "rectilinear").groups
    assert [set(group) for group in shuffled] == [set(group) for group in pooled.groups]


def test_nothing_to_pool_is_an_error() -> None:
    few = Member("x", "y", (View(np.zeros((2, 3)), np.zeros((2, 2))),))
    for members, code in (([], "no_members"), ([few], "too_few_points")):
        with pytest.raises(CalibrationError) as caught:
            pool(members, SIZE, "rectilinear")
        assert caught.value.code == code


@pytest.mark.parametrize("focal", [1.0, 1.3])
def test_few_members_are_consistent_where_they_would_be_reliable(honest: list[Member], focal: float) -> None:
    members = [honest[0], member(1, focal)]
    found = pool(members, SIZE, "rectilinear")
    assert (found.reliable, found.reason) == (False, "too_few")
    enough = pool(members, SIZE, "rectilinear", Rule(min_calibrations=1))
    assert found.consistent == enough.consistent == enough.reliable == (focal == 1.0)
    assert_same_camera(found, enough)


@pytest.fixture
def fitted(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    made: list[str] = []

    def counted(views: Sequence[View], img_size: tuple[int, int], model: str) -> Calibration:
        made.append(model)
        return fit(views, img_size, model)

    monkeypatch.setattr(fit_memory, "fit", counted)
    fit_memory.forget()
    yield made
    fit_memory.forget()


def test_a_new_calibration_alone_is_fitted(fitted: list[str]) -> None:
    members = [member(seed) for seed in range(3)]
    pool(members[:2], SIZE, "rectilinear")
    assert fitted == ["rectilinear"] * 2
    again = [replace(m, views=tuple(replace(view) for view in m.views)) for m in members]
    warm = pool(again, SIZE, "rectilinear")
    assert fitted == ["rectilinear"] * 3  # their documents were read again
    pool(again, SIZE, "rectilinear", Rule(min_contributors=1, min_calibrations=1))
    assert fitted == ["rectilinear"] * 3
    fit_memory.forget()
    cold = pool(members, SIZE, "rectilinear")
    assert cold.calibration.record() == warm.calibration.record()


def test_nothing_else_is_taken_for_it(fitted: list[str]) -> None:
    views = member(1).views
    shifted = [View(v.object_points, v.image_points + 1e-9) for v in views]
    weighed = [View(v.object_points, v.image_points, np.arange(1.0, len(v) + 1)) for v in views]
    scaled = [View(2 * v.object_points, v.image_points) for v in views]
    for each, size, model in (
        (views, SIZE, "rectilinear"),
        (shifted, SIZE, "rectilinear"),
        (scaled, SIZE, "rectilinear"),
        (weighed, SIZE, "rectilinear"),
        (views[::-1], SIZE, "rectilinear"),
        (views, (SIZE[0], SIZE[1] + 2), "rectilinear"),
        (views, SIZE, "rational"),
    ):
        assert fit_memory.fit_once(each, size, model).camera.img_size == size
    assert len(fitted) == 7
    for _ in range(2):  # a refusal is not remembered
        with pytest.raises(CalibrationError):
            fit_memory.fit_once([], SIZE, "rectilinear")
    assert len(fitted) == 9


def test_consensus_of_one_calibration_is_its_fit(fitted: list[str]) -> None:
    one = member(1)
    alone = pool([one], SIZE, "rectilinear")
    assert alone.calibration is fit_memory.fit_once(one.views, SIZE, "rectilinear")
    assert fitted == ["rectilinear"]


def test_cache_beyond_its_points_drops_the_oldest_fit(
    fitted: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    members = [member(seed) for seed in range(4)]
    points = [sum(map(len, m.views)) for m in members]
    monkeypatch.setattr(fit_memory, "MAX_POINTS", sum(points[1:]))
    for one in members:
        fit_memory.fit_once(one.views, SIZE, "rectilinear")
    assert fit_memory.cached_points() == sum(points[1:])
    for one in (*members[1:], members[0]):
        fit_memory.fit_once(one.views, SIZE, "rectilinear")
    assert len(fitted) == 5
