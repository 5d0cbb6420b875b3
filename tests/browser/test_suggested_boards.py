"""Suggestions of other boards before the camera."""

from pathlib import Path

import cv2
import pytest
from playwright.sync_api import Playwright, expect

from calibdb_client import Board
from tests.helpers import board_pictures
from tests.helpers.browser import stop_and_go
from tests.helpers.browser.frame_rate import WATCH
from tests.helpers.marks import thorough

#: three seconds of the camera's 8 per second; 8 to 13 were measured
MAX_FRAMES = 24
CHESSBOARD, CHARUCO = "10 × 7 chessboard", "8 × 8 ChArUco, DICT_4X4_50, markers 0.75"
SHOWN = {CHESSBOARD: Board((10, 7), kind="chessboard"), CHARUCO: Board((8, 8), 0.75)}
# Instructions, each with the frames that were looked at before
LISTEN = """
  window.texts = [];
  document.addEventListener("DOMContentLoaded", () => {
    const place = document.getElementById("instruction");
    new MutationObserver(() => window.texts.push([window.pace.frames, place.textContent]))
      .observe(place, { childList: true, characterData: true, subtree: true });
  });
"""


@pytest.mark.parametrize("words", [*thorough(CHESSBOARD), CHARUCO])
def test_board_is_suggested_after_few_frames(
    playwright: Playwright, stack: str, tmp_path: Path, words: str
) -> None:
    board = SHOWN[words]
    grey = board_pictures.picture(board, board_pictures.TILTS[1], 1.5 * max(board.size))
    frame = cv2.cvtColor(cv2.resize(grey, (1280, 720)), cv2.COLOR_GRAY2BGR)
    source = stop_and_go.write(tmp_path / "camera.y4m", [frame] * 4)
    with stop_and_go.camera(playwright, stack, source) as page:
        page.add_init_script(WATCH + LISTEN)
        page.goto("/calibrate/")
        page.locator("#start").click()
        page.locator("#instruction", has_text="This is a different board").wait_for()
        expect(page.locator("#remedy")).to_contain_text(words)
        texts = page.evaluate("window.texts")
    assert not [text for _, text in texts if "Move closer" in text]
    assert texts[-1][0] - texts[0][0] <= MAX_FRAMES
