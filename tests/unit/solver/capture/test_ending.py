"""End of a capture by its course."""

import pytest

from calibsolver.capture import History

FALLING = (None, 9.0, 5.0, 3.0, 2.0, 1.5, 1.2, 1.0, 0.8, 0.6)
FLAT = (None, 9.0, 5.0, 3.0, 2.0, 1.0, 0.8, 0.78, 0.76, 0.75)


def plateau(stated: tuple[float | None, ...], on_target: tuple[bool, ...] | None = None) -> bool:
    on_target = on_target or (True,) * len(stated)
    last = stated[-1]
    assert last is not None
    return History((*stated[:-1], None), on_target).has_plateau(last, len(stated))


def test_error_that_falls_no_more_is_a_plateau_from_ten_views_on() -> None:
    assert not plateau(FALLING)
    assert plateau(FLAT)
    assert not plateau(FLAT[:9])


def test_views_off_the_target_are_no_plateau() -> None:
    for off in range(6, 10):
        assert plateau(FLAT, tuple(i != off for i in range(10))) == (off == 6)


def test_error_that_jumped_is_no_plateau_and_one_jump_hides_none() -> None:
    """By the running minimum one view that is off is no progress afterwards, nor does it end a capture."""
    assert not plateau((None, 9.0, 5.0, 1.0, 0.8, 0.8, 0.8, 0.8, 0.8, 66.0))
    assert plateau((None, 9.0, 5.0, 1.0, 0.8, 0.8, 66.0, 0.8, 0.8, 0.8))
    assert plateau((None, 9.0, 5.0, 1.0, 0.8, 0.8, None, 0.8, 0.8, 0.8))


@pytest.mark.parametrize(("duplicates", "count", "ends"), [(5, 9, False), (6, 3, False), (6, 4, True)])
def test_six_duplicates_in_a_row_end_a_capture_of_four_views(duplicates: int, count: int, ends: bool) -> None:
    assert History(duplicates=duplicates).is_exhausted(count) is ends
