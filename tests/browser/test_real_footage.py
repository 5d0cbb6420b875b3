"""Real footage as the camera of the capture page."""

import re
import time
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import pytest
from playwright.sync_api import Page, Playwright, expect

from tests.helpers.browser import stop_and_go
from tests.helpers.browser.waiting import shown_calibration
from tests.helpers.data import data_dir, external_data
from tests.helpers.marks import thorough

pytestmark = [external_data, pytest.mark.alone]

RESULT_S = 90.0
SUGGESTION_S = 4.0
FALSE_S = 2.0
"""Seconds for which a false order may stand on the screen."""
UNTRUE = (
    "Stripes",
    "Blurred",
    "Too dark",
    "Too bright",
    "Too far",
    "Move more slowly",
    "Hold it still for longer",
)
"""Words of what these videos do not have while a pose is held."""
INVERTED = "squares=4x5&marker_ratio=0.75&inverted=true"

# Each text of the page, with the time at which it appeared, ms
WATCH = """
  window.told = [];
  document.addEventListener("DOMContentLoaded", () => {
    const texts = () => ["instruction", "remedy", "away"].map((id) => document.getElementById(id))
      .filter((place) => place && !place.closest("[hidden]"))
      .map((place) => place.textContent.trim()).join(" | ");
    const write = () => {
      const now = texts();
      if (now !== window.told.at(-1)?.text) window.told.push({ time: performance.now(), text: now });
    };
    const changes = { subtree: true, childList: true, characterData: true, attributes: true };
    new MutationObserver(write).observe(document.body, changes);
  });
"""


@dataclass(frozen=True)
class Footage:
    """A video from its `first` frame with a board; `ratio`: fx over the width, within `tolerance`."""

    file: str
    query: str
    words: str
    first: int
    ratio: float
    tolerance: float


OPT1 = Footage("caliscope_opt1.mp4", INVERTED, "4 × 5 ChArUco", 9, 760.3 / 1280, 0.05)
YUBIN = Footage(
    "chessboard_yubin.mp4", "kind=chessboard&squares=9x7", "9 × 7 chessboard", 0, 1123.6 / 1280, 0.05
)


@pytest.fixture(scope="module", params=[*thorough(OPT1), YUBIN], ids=["opt1", "yubin"])
def footage(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[tuple[Footage, Path]]:
    made: Footage = request.param
    frames = stop_and_go.frames_of(data_dir() / "videos" / made.file)[made.first :]
    path = tmp_path_factory.mktemp("footage") / "camera.y4m"
    stop_and_go.write(path, stop_and_go.stop_and_go(frames))
    yield made, path
    path.unlink()


def spans(page: Page) -> list[tuple[str, float]]:
    """Texts of the page, and for how many seconds each stood."""
    told = page.evaluate("[...window.told, { time: performance.now(), text: '' }]")
    return [(before["text"], (after["time"] - before["time"]) / 1000) for before, after in pairwise(told)]


@pytest.mark.parametrize("is_given", [*thorough(True), False], ids=["given", "recognised"])
def test_who_holds_still_gets_a_result_with_a_verdict(
    playwright: Playwright, stack: str, footage: tuple[Footage, Path], is_given: bool
) -> None:
    made, source = footage
    with stop_and_go.camera(playwright, stack, source) as page:
        page.add_init_script(WATCH)
        page.goto(f"/calibrate/?{made.query if is_given else ''}")
        page.locator("#start").click()
        page.locator("#reticle:not([hidden])").wait_for()
        began = time.monotonic()
        if not is_given:
            page.locator("#use-board").wait_for(timeout=1000 * SUGGESTION_S)
            expect(page.locator("#remedy")).to_contain_text(made.words)
            page.locator("#use-board").click()
        page.locator("#done:not([hidden]) #verdict").wait_for(timeout=1000 * RESULT_S)
        seconds = time.monotonic() - began
        calibration = shown_calibration(page)
        ratio = calibration["camera_matrix"][0][0] / calibration["img_size"][0]
        print(
            f"{made.file}: result after {seconds:.0f} s, fx / width {ratio:.3f}, "
            f"expected error {calibration['uncertainty']['rms']:.1f} px"
        )
        assert abs(ratio / made.ratio - 1) < made.tolerance
        assert seconds < RESULT_S
        said = spans(page)
        assert not [text for text, _ in said if any(words in text for words in UNTRUE)]
        away = [(text, seconds) for text, seconds in said if "Show the board" in text and seconds > FALSE_S]
        assert not away


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("file", "rate", "first", "words", "query"),
    [
        ("caliscope_pre1_mirrored.mp4", 6, 0, "The picture is mirrored", "squares=4x5.*flipped=true"),
        ("caliscope_char0_mpeg4.mp4", 6, 66, "4 × 5 ChArUco", "squares=4x5"),
        ("chessboard_uk.avi", 30, 0, "11 × 8 chessboard", "squares=11x8"),
    ],
    ids=["mirrored", "hidden markers", "partly outside"],
)
def test_a_board_is_recognised_as_a_whole_and_used(
    playwright: Playwright,
    stack: str,
    tmp_path: Path,
    file: str,
    rate: int,
    first: int,
    words: str,
    query: str,
) -> None:
    """Footage as it was taken, from its first frame with the board on."""
    frames = stop_and_go.frames_of(data_dir() / "videos" / file)[first:]
    source = stop_and_go.write(tmp_path / "camera.y4m", [*frames, *frames[::-1]], rate)
    with stop_and_go.camera(playwright, stack, source) as page:
        page.goto("/calibrate/")
        page.locator("#start").click()
        page.locator("#reticle:not([hidden])").wait_for()
        page.locator("#use-board").wait_for()
        expect(page.locator("#instruction, #remedy").filter(has_text=words)).to_have_count(1)
        page.locator("#use-board").click()
        expect(page.locator("#corners .corner")).not_to_have_count(0)
        assert re.search(query, page.url)
