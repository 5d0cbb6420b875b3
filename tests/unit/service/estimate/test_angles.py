"""Conversions between diagonal, horizontal and vertical angles, focal lengths, and their logarithm."""

import math

import pytest

from calibdb.estimate.angles import horizontal_angle, log_tan


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
