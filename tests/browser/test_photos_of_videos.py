"""Real videos on the photos page."""

import re

import pytest
from playwright.sync_api import Page, expect

from tests.helpers.data import data_dir, external_data

pytestmark = [external_data, pytest.mark.alone, pytest.mark.thorough]

WHITE_ON_BLACK = "4 × 5 ChArUco, DICT_4X4_50, markers 0.75, white on black"


@pytest.mark.parametrize(
    ("name", "words", "frames"),
    [
        ("caliscope_opt1.mp4", ("Is this your board?", WHITE_ON_BLACK), 57),
        ("caliscope_pre1_mirrored.mp4", ("mirrored", WHITE_ON_BLACK), 120),
        ("chessboard_yubin.mp4", ("Is this your board?", "9 × 7 chessboard"), 120),
    ],
    ids=["opt1", "mirrored", "yubin"],
)
def test_video_has_a_result_with_its_address(
    page: Page, name: str, words: tuple[str, ...], frames: int
) -> None:
    page.goto("/photos/")
    page.locator("#files").set_input_files(data_dir() / "videos" / name)
    for each in words:
        expect(page.locator("#question-text")).to_contain_text(each)
    page.locator("#use-board").click()
    page.locator("#status", has_text="video frames").wait_for()
    status = re.search(r"(\d+) of (\d+) video frames", page.locator("#status").text_content() or "")
    assert status is not None
    assert int(status[2]) <= frames
    page.locator("#camera").fill("Webcam of a video")
    page.locator("#start").click()
    page.locator("#verdict").wait_for()
    assert "/result/?id=" in page.url
    expect(page.locator("#json")).to_contain_text("camera_matrix")
