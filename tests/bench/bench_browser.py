"""The detector in its Worker, and the capture page with a camera: pace, memory, first detection. Chromium."""

import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from playwright.sync_api import sync_playwright

from infra.local import LocalStack
from tests.bench.table import Row
from tests.browser.conftest import CHROMIUM
from tests.browser.test_detector import WATCH
from tests.helpers.browser.pace import best_pace, camera, first_detection

FRAMES = 2_000


def rows() -> Iterator[Row]:
    path = shutil.which("chromium")
    if path is None:
        return
    with LocalStack() as stack, stack.serve() as url, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=CHROMIUM)
        page = browser.new_page(base_url=url, service_workers="block")
        first = min([first_detection(page) for _ in range(4)][1:])
        page.goto("/board/")
        seen = page.evaluate(WATCH, FRAMES)
        browser.close()
        with tempfile.TemporaryDirectory() as folder, camera(playwright, url, Path(folder), rate=30) as page:
            pace = best_pace(page)
    memory = np.array(seen["memory"])
    yield Row(
        "browser: detection 1280x720, a frame", float(np.median(seen["elapsed"])), 66.7, "ms", "15 frames/s"
    )
    yield Row("browser: detection of the frame that is sent", seen["full"]["elapsed"], None, "ms")
    yield Row("browser: memory of the detector", memory[-1] / 1e6, None, "MB", f"after {FRAMES} frames")
    yield Row("browser: growth of the detector's memory", float(memory[-1] - memory[0]) / 1e6, 0.0, "MB")
    yield Row("browser: time of a frame in the capture", 1000 / pace.rate, 66.7, "ms", "15 frames/s")
    yield Row("browser: longest task of the page", pace.longest, 50.0, "ms", "0: none reached 50 ms")
    yield Row("browser: first detection, from cache", first, 3.0, "s")
