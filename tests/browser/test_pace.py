"""The page keeps up with a hand, and stays responsive meanwhile."""

from pathlib import Path

import pytest
from playwright.sync_api import Page, Playwright

from tests.helpers.browser.pace import camera, detection_kept, first_detection, pace_kept

RATE = 15  # detections/s
RESPONSIVE = 50  # ms
SEEN_WITHIN = 3.0  # s


@pytest.mark.alone
def test_fifteen_frames_a_second_while_the_page_stays_responsive(
    playwright: Playwright, stack: str, tmp_path: Path
) -> None:
    with camera(playwright, stack, tmp_path, rate=30) as page:
        pace = pace_kept(page, RATE, RESPONSIVE)
    assert pace.rate >= RATE
    assert pace.longest < RESPONSIVE


@pytest.mark.alone
def test_the_board_is_looked_for_within_three_seconds(page: Page) -> None:
    first_detection(page)  # so that the browser has what it needs
    assert detection_kept(page, SEEN_WITHIN) < SEEN_WITHIN
