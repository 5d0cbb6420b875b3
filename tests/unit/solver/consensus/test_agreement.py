"""Groups of calibrations that agree."""

from itertools import product

import numpy as np
import pytest

from calibsolver import Calibration, Camera, View
from calibsolver.consensus.agreement import difference
from calibsolver.consensus.fit_memory import fit_once
from calibsolver.consensus.pooling import Member, Rule, pool
from tests.helpers.data import available, corner_views, external_data
from tests.helpers.marks import thorough
from tests.helpers.solver import attacks, populations, synthetic


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


@pytest.mark.parametrize("number", [938, *thorough(810)])
def test_answer_is_not_moved_where_noise_might_excuse_lies(number: int) -> None:
    """Of 1,000 cameras those whose lies moved a fit to all points by over half a pixel."""
    rng = np.random.default_rng((7, number))
    found = attacks.trial(rng, attacks.KINDS[number % 4], int(rng.integers(5, 13)))
    assert not found.wrong


def fitted(member: Member) -> Calibration:
    return fit_once(member.views, synthetic.IMG_SIZE, "rectilinear")


def contribute(name: str, camera: Camera, effort: attacks.Effort, rng: np.random.Generator) -> Member:
    return Member(name, name, tuple(populations.views(camera, rng, effort.noise, effort.views)))


def test_honest_contributors_of_poor_views_weigh_little() -> None:
    camera, rng = synthetic.rectilinear_cameras()[5], np.random.default_rng(4)
    precise = [contribute(f"p{i}", camera, attacks.Effort(6), rng) for i in range(5)]
    poor = [contribute(f"v{i}", camera, attacks.EFFORTS["very poor views"], rng) for i in range(2)]
    before, after = (
        pool(group, camera.img_size, "rectilinear", attacks.RULE) for group in (precise, [*precise, *poor])
    )
    assert before.reliable
    assert after.reliable
    assert set(after.members) >= {member.id for member in precise}
    worst = max(difference(camera, fitted(m).camera) for m in poor)
    assert worst > 2
    assert difference(before.calibration.camera, after.calibration.camera) < worst / 10


def test_consensus_that_states_too_much_is_imprecise() -> None:
    camera, rng = synthetic.rectilinear_cameras()[5], np.random.default_rng(4)
    members = [contribute(str(i), camera, attacks.Effort(3, 3.0), rng) for i in range(5)]
    pooled = pool(members, camera.img_size, "rectilinear", attacks.RULE)
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


def test_groups_do_not_depend_on_order() -> None:
    rng = np.random.default_rng(2)
    camera = synthetic.rectilinear_cameras()[4]
    specimens = [attacks.vary(camera, 0.002, rng) for _ in range(6)]
    k = camera.intrinsics
    k[:2] *= 1.03
    specimens += [Camera.from_intrinsics("rectilinear", k, camera.img_size)] * 2
    members = [Member(str(i), str(i), tuple(populations.views(c, rng))) for i, c in enumerate(specimens)]
    order = rng.permutation(8)
    groups = pool(members, camera.img_size, "rectilinear").groups
    assert groups == (tuple("012345"), tuple("67"))
    shuffled = pool([members[i] for i in order], camera.img_size, "rectilinear").groups
    assert [set(group) for group in shuffled] == [set(group) for group in groups]


REAL = {"jy_left": "fisheye", "babel_ov_plane": "fisheye"} | dict.fromkeys(
    ("pv_picam_320", "pv_picam_640", "pv_picam_960"), "rectilinear"
)


@pytest.mark.parametrize("name", ["jy_left", *thorough(*available(sorted(REAL.keys() - {"jy_left"})))])
def test_contributors_of_one_real_camera_agree(name: str) -> None:
    views, size = corner_views(name)
    order = np.random.default_rng(0).permutation(len(views))
    count = min(8, len(views) * 3 // 20)
    parts = [[views[i] for i in order[a * count : (a + 1) * count]] for a in range(5)]
    members = [Member(str(a), str(a), tuple(part)) for a, part in enumerate(parts)]
    pooled = pool(members, size, REAL[name], Rule(min_contributors=3))
    assert pooled.members == tuple("01234")
    assert pooled.calibration.uncertainty().rms < 6, "also at the rim of a fisheye's domain"


@external_data
@pytest.mark.parametrize(
    "pair", [("pv_picam_640", "pv_picam_960"), *thorough((("pv_picam_320", "pv_picam_640"),))]
)
def test_another_mode_of_a_real_camera_is_kept_out(pair: tuple[str, str]) -> None:
    views, size = corner_views(pair[0])
    others, other_size = corner_views(pair[1])
    scale = np.array(size) / other_size
    rng = np.random.default_rng(0)
    order, drawn = rng.permutation(len(views)), rng.permutation(len(others))[:4]
    members = [Member(str(a), str(a), tuple(views[i] for i in order[4 * a : 4 * a + 4])) for a in range(5)]
    resized = [View(others[i].object_points, (others[i].image_points + 0.5) * scale - 0.5) for i in drawn]
    found = pool([*members, Member("other mode", "5", tuple(resized))], size, "rectilinear")
    assert found.members == tuple("01234")
