"""The page keeps up with a hand, and stays responsive meanwhile."""

from pathlib import Path

import pytest
from playwright.sync_api import Page, Playwright

from .pace import best_pace, camera, first_detection


@pytest.mark.alone
def test_fifteen_frames_a_second_while_the_page_stays_responsive(
    playwright: Playwright, stack: str, tmp_path: Path
) -> None:
    with camera(playwright, stack, tmp_path, rate=30) as page:
        pace = best_pace(page)
    print(f"{pace.rate:.1f} detections/s; longest task {pace.longest:.0f} ms (0: none of 50 ms)")
    assert pace.rate >= 15
    assert pace.longest < 50


@pytest.mark.alone
def test_the_board_is_looked_for_within_three_seconds(page: Page) -> None:
    seconds = first_detection(page)
    print(f"first detection {seconds:.2f} s after navigation")
    assert seconds < 3
