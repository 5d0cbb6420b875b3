"""Real videos: detection by the Python client, and the photos page from the file to the result."""

import time
from collections.abc import Iterator

from playwright.sync_api import Browser, sync_playwright

from calibdb_client.capture.video import read_video
from calibdb_client.pictures import FoundViews
from infra.server.server import Server
from tests.bench.table import Row
from tests.browser.conftest import CHROMIUM, chromium_path
from tests.helpers import data

CHARUCO, CHESSBOARD = "caliscope_opt1.mp4", "chessboard_yubin.mp4"
LENGTHS = {CHARUCO: 57 / 6, CHESSBOARD: 260 / 24}
"""s; the camera of the first took 6 frames/s."""
ROUNDS = 3


def rows() -> Iterator[Row]:
    """Processor time per second of video, the least of some rounds in turn."""
    if data.EXTERNAL is None:  # licences keep the videos out of `tests/data`
        return
    taken = {
        name: min(seconds)
        for name, seconds in zip(LENGTHS, zip(*map(once, range(ROUNDS)), strict=True), strict=True)
    }
    note = ", ".join(f"{name} {value:.2f} s/s" for name, value in taken.items())
    yield Row("video of a chessboard / of a ChArUco board", taken[CHESSBOARD] / taken[CHARUCO], 2, "x", note)
    with Server() as stack, stack.serve() as url, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium_path(), args=CHROMIUM)
        for name, length in LENGTHS.items():
            seconds = min(photos_page(browser, url, name) for _ in range(ROUNDS))
            yield Row(
                f"photos page: {name}, {length:.1f} s", seconds, 15.0, "s", "from the file to the result"
            )
        browser.close()


def once(_round: int) -> list[float]:
    """Processor time of each video / its length."""
    shares = []
    for name, length in LENGTHS.items():
        begun = time.process_time()
        read_video(data.data_dir() / "videos" / name, None, FoundViews())
        shares.append((time.process_time() - begun) / length)
    return shares


def photos_page(browser: Browser, url: str, name: str) -> float:
    """Seconds from the choice of a video to its result."""
    page = browser.new_page(base_url=url, service_workers="block")
    page.goto("/photos/")
    begun = time.monotonic()
    page.locator("#files").set_input_files(data.data_dir() / "videos" / name)
    page.locator("#use-board").click()
    page.locator("#status", has_text="video frames").wait_for()
    page.locator("#camera").fill("Camera of a video")
    page.locator("#start").click()
    page.locator("#verdict").wait_for()
    seconds = time.monotonic() - begun
    page.close()
    return seconds
