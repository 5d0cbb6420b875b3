"""Clustering of calibrations: liars, hidden modes, published lens profiles."""

import itertools

import numpy as np
import pytest

from calibsolver import fit
from calibsolver.consensus.agreement import Projections, compare, forward_search
from calibsolver.consensus.pooling import Member, pool
from tests.helpers.data import external_data
from tests.helpers.solver import attacks, populations, synthetic


@pytest.mark.parametrize("kind", attacks.KINDS)
def test_lying_minority_does_not_move_the_consensus(kind: str) -> None:
    """By half a pixel over the image, from just beside the truth to 30 % off; no answer is no harm."""
    rng = np.random.default_rng(5)
    totals = (5, 10) if kind == "junk" else (5, 8, 12)
    trials = [attacks.trial(rng, kind, total) for total in totals]
    assert not [(t.total, t.moved) for t in trials if t.wrong]
    # With six honest ones and more there is an answer all the same.
    assert all(t.reliable for t in trials if t.total >= 10)


@pytest.mark.parametrize("number", [810, 938])
def test_answer_is_not_moved_where_noise_might_excuse_lies(number: int) -> None:
    """The two of 1,000 cameras whose lies moved a fit to all points by over half a pixel."""
    rng = np.random.default_rng((7, number))
    found = attacks.trial(rng, attacks.KINDS[number % 4], int(rng.integers(5, 13)))
    assert not found.wrong


def test_two_contributors_are_never_reliable() -> None:
    """Two contributors with most of the calibrations: too few contributors, however well they agree."""
    rng = np.random.default_rng(1)
    liars = attacks.lies("focal", synthetic.rectilinear_cameras()[5], 6, 0.0, rng, 5)
    members = [Member(f"l{i}", f"l{i % 2}", views) for i, views in enumerate(liars)]
    pooled = pool(members, (1280, 720), "rectilinear", attacks.RULE)
    assert (pooled.reliable, pooled.reason) == (False, "few_contributors")


@external_data
def test_lens_profiles_agree_only_within_a_mode() -> None:
    """Draws of five: of two modes whose lens and setting are named, and across the lenses of one camera."""
    rng = np.random.default_rng(0)
    profiles = populations.profiles()
    together = 0
    for lens in ("EF-S10-18mm f/4.5-5.6 IS STM 10.00mm", "RF16mm F2.8 STM 16.00mm"):
        found = next(v for mode, v in profiles.items() if mode[2] == lens and mode[3] and len(v) == 6)
        members = populations.members(found, rng)
        for draw in itertools.islice(itertools.combinations(members, 5), 3):
            together += pool(draw, found[0][0].img_size, "fisheye").reliable
    assert together >= 5  # of 6
    lenses = [v for mode, v in profiles.items() if mode[1] == "KOMODO 6K" and mode[2] and mode[4] == "5760"]
    for _ in range(4):
        drawn = [lenses[i][0] for i in rng.choice(len(lenses), 5, replace=False)]
        assert not pool(populations.members(drawn, rng), drawn[0][0].img_size, "fisheye").reliable


def test_forward_search_does_not_depend_on_order() -> None:
    rng = np.random.default_rng(2)
    camera = synthetic.rectilinear_cameras()[4]
    c = [fit(populations.views(attacks.vary(camera, 0.002, rng), rng), camera.img_size) for _ in range(6)]
    order = rng.permutation(6)
    np.testing.assert_allclose(compare([c[i] for i in order]), compare(c)[np.ix_(order, order)], atol=1e-9)
    assert {int(order[i]) for i in forward_search(Projections.of([c[i] for i in order]), 12.8, 0.8)} == set(
        forward_search(Projections.of(c), 12.8, 0.8)
    )
