"""Conversions between angles and focal lengths, and the robust combination of evidence by precision."""

import math

import pytest

from calibdb.estimate.angles import horizontal_angle, log_tan
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


@pytest.mark.parametrize(
    ("quantity", "value", "size", "hfov"),
    [
        ("hfov", 70.42, (1920, 1080), 70.42),
        ("vfov", 43.3, (1920, 1080), 70.4),
        ("dfov", 77.9, (16, 9), 70.4),
        ("fx", 960, (1920, 1080), 90.0),
        ("f35", 26, (4, 3), 67.3),
    ],
)
def test_horizontal_angle_of_a_pinhole(
    quantity: str, value: float, size: tuple[int, int], hfov: float
) -> None:
    assert horizontal_angle(log_tan(quantity, value, size)) == pytest.approx(hfov, abs=0.1)


def test_angles_are_limited() -> None:
    assert horizontal_angle(-math.inf) == pytest.approx(2)
    assert horizontal_angle(100.0) == pytest.approx(170)
    with pytest.raises(ValueError, match="no field of view"):
        log_tan("hfov", 180, (16, 9))
