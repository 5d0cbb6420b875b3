"""Groups of calibrations that agree."""

from itertools import product

import numpy as np
import pytest

from calibsolver import Calibration
from calibsolver.consensus.agreement import difference
from calibsolver.consensus.fit_memory import fit_once
from calibsolver.consensus.pooling import Member, pool
from tests.helpers.data import external_data
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


def test_honest_contributors_of_poor_views_weigh_little() -> None:
    camera, rng = synthetic.rectilinear_cameras()[5], np.random.default_rng(4)
    precise = [populations.member(f"p{i}", camera, rng) for i in range(5)]
    poor = [populations.member(f"v{i}", camera, rng, noise=2.0, count=3) for i in range(2)]
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
    members = [populations.member(str(i), camera, rng, noise=3.0, count=3) for i in range(5)]
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
