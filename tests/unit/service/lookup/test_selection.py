"""Selection of a consensus: the exact size, else the closest reliable one by aspect, then by area."""

import pytest

from calibdb.lookup.selection import choose
from calibdb.schema import ConsensusDocument
from tests.helpers.service.known import consensus, fit


def stored(
    size: tuple[int, int],
    model: str = "rectilinear",
    reason: str | None = None,
    zoom: float = 0.0,
    total: int = 5,
) -> ConsensusDocument:
    return consensus(fit(size, model=model), zoom=zoom, reason=reason, calibrations=total)


HD, FULL_HD, VGA, SD = (1280, 720), (1920, 1080), (640, 480), (854, 480)


@pytest.mark.parametrize(
    ("sizes", "asked", "answered"),
    [
        ([HD, FULL_HD, VGA], HD, HD),
        ([FULL_HD, VGA], HD, FULL_HD),  # same aspect before closer area
        ([SD, VGA], HD, SD),
        ([VGA], HD, VGA),
        ([VGA, (1600, 1200)], (1024, 768), (1600, 1200)),  # 2.4 times the area, not a 2.6th
        ([SD, FULL_HD, (3840, 2160)], (3000, 1687), (3840, 2160)),  # 16:9 to the pixel, and almost
        ([(720, 1280), VGA], HD, VGA),
    ],
)
def test_closest_size(
    sizes: list[tuple[int, int]], asked: tuple[int, int], answered: tuple[int, int]
) -> None:
    known = [stored(size) for size in sizes]
    for order in (known, known[::-1]):
        choice = choose(order, asked, 0.0, "rectilinear")
        assert choice.found is not None
        assert choice.found.img_size == answered


def test_only_reliable_consensuses_answer() -> None:
    choice = choose([stored(HD, reason="disagree"), stored(VGA)], HD, 0.0, "rectilinear")
    assert choice.found is not None
    assert choice.found.img_size == VGA
    choice = choose([stored(HD, reason="disagree"), stored(VGA, reason="too_few")], HD, 0.0, "rectilinear")
    assert (choice.found, choice.reason) == (None, "disagree")


def test_missing_model_is_computed_where_another_is_reliable() -> None:
    assert choose([stored(HD)], FULL_HD, 0.0, "fisheye").missing_at == HD
    assert choose([stored(HD, reason="too_few")], HD, 0.0, "fisheye").missing_at is None
    both = [stored(HD), stored(HD, "fisheye", reason="disagree")]
    choice = choose(both, HD, 0.0, "fisheye")
    assert (choice.missing_at, choice.reason) == (None, "disagree")


def test_outdated_model_is_recomputed() -> None:
    # A session asks for both models; between the two a lookup must not hear yesterday's answer.
    known = [stored(HD), stored(HD, "fisheye", reason="too_few", total=4)]
    assert choose(known, HD, 0.0, "fisheye").missing_at == HD


def test_another_zoom_never_answers() -> None:
    assert choose([stored(HD, zoom=1.0)], HD, 0.0, "rectilinear").found is None
    assert choose([stored(HD, zoom=1.0)], HD, 1.0, "rectilinear").found is not None


def test_nothing_known() -> None:
    choice = choose([], HD, 0.0, "rectilinear")
    assert (choice.found, choice.missing_at, choice.reason) == (None, None, "unknown_camera")
