"""The detector in its Worker in Chromium, on frames of the virtual camera."""

import shutil
from collections.abc import Iterator

import numpy as np
from playwright.sync_api import sync_playwright

from infra.local import LocalStack
from tests.bench.table import Row
from tests.browser.conftest import CHROMIUM
from tests.browser.test_detector import WATCH

FRAMES = 100


def rows() -> Iterator[Row]:
    path = shutil.which("chromium")
    if path is None:
        return
    with LocalStack() as stack, stack.serve() as url, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=CHROMIUM)
        page = browser.new_page(base_url=url)
        page.goto("/board/")
        seen = page.evaluate(WATCH, FRAMES)
        browser.close()
    yield Row(
        "browser: detection 1280x720, a frame", float(np.median(seen["elapsed"])), 66.7, "ms", "15 frames/s"
    )
    yield Row("browser: detection of the frame that is sent", seen["full"]["elapsed"], None, "ms")
    yield Row(
        "browser: memory of the detector", seen["memory"][-1] / 1e6, None, "MB", f"after {FRAMES} frames"
    )
