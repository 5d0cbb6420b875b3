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

LENGTHS = {"caliscope_opt1.mp4": 57 / 6, "chessboard_yubin.mp4": 260 / 24}
"""s, of a video of a ChArUco board and of one of a chessboard."""
ROUNDS = 3


def rows() -> Iterator[Row]:
    if data.EXTERNAL is None:  # licences keep the videos out of `tests/data`
        return
    rounds = [[detection(name) for name in LENGTHS] for _ in range(ROUNDS)]
    charuco, chessboard = (min(times) for times in zip(*rounds, strict=True))
    note = f"{charuco:.2f} and {chessboard:.2f} s/s"
    yield Row("video of a chessboard / of a ChArUco board", chessboard / charuco, 2, "x", note)
    with Server() as stack, stack.serve() as url, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium_path(), args=CHROMIUM)
        for name, length in LENGTHS.items():
            seconds = min(photos_page(browser, url, name) for _ in range(ROUNDS))
            what = f"photos page: {name}, {length:.1f} s"
            yield Row(what, seconds, 15.0, "s", "from the file to the result")
        browser.close()


def detection(name: str) -> float:
    """Processor time per second of video."""
    begun = time.process_time()
    read_video(data.data_dir() / "videos" / name, None, FoundViews())
    return (time.process_time() - begun) / LENGTHS[name]


def photos_page(browser: Browser, url: str, name: str) -> float:
    """Seconds from the choice of a video to its result."""
    page = browser.new_page(base_url=url, service_workers="block")
    page.set_default_timeout(120_000)
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
