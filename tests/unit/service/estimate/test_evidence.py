"""Robust combination of evidence by precision."""

import math

import pytest

from calibdb.estimate.evidence import Evidence, combine, mixture


def evidence(mean: float, sigma: float) -> Evidence:
    return Evidence("published", mean, sigma)


def test_agreeing_evidence_is_weighted_by_its_precision() -> None:
    mean, sigma = combine([evidence(0.0, 0.1), evidence(0.03, 0.05)])
    assert mean == pytest.approx(0.024, abs=0.001)
    assert sigma == pytest.approx(1 / math.sqrt(100 + 400), rel=0.02)


def test_one_wrong_statement_does_not_win() -> None:
    right = [evidence(0.0, 0.04), evidence(0.01, 0.04), evidence(-0.01, 0.04)]
    mean, _ = combine([*right, evidence(1.0, 0.02)])
    assert abs(mean) < 0.03


def test_contradiction_widens() -> None:
    _, alone = combine([evidence(0.0, 0.04)])
    mean, both = combine([evidence(0.0, 0.04), evidence(0.5, 0.04)])
    assert both > 3 * alone
    assert mean - 2 * both < 0.0 or mean + 2 * both > 0.5


def test_mixture_of_modes_covers_them() -> None:
    mean, sigma = mixture([(1.0, -0.2, 0.02), (1.0, 0.2, 0.02)])
    assert mean == pytest.approx(0.0)
    assert sigma == pytest.approx(math.hypot(0.2, 0.02))
