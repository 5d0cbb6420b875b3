"""Detector, capture page and rectifier in Chromium: frame rate, longest task, memory, first detection."""

import json
import statistics
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from playwright.sync_api import Playwright, sync_playwright

from calibdb.settings import Settings
from calibdb.store import Store
from infra.server.server import DEVELOPMENT_TOKEN, Server
from tests.bench.table import Row
from tests.browser.conftest import CHROMIUM, chromium_path
from tests.browser.test_camera import DETECTIONS
from tests.browser.test_kept_files import HOST, kept
from tests.browser.test_rectifier import calibration
from tests.helpers.browser.fake_camera import camera
from tests.helpers.browser.firefox import firefox
from tests.helpers.browser.frame_rate import RECTIFIED_AT_RATE, first_detection, median_pace

FRAMES = 2_000
RATE = 30  # frames/s of the rectifier's video
FRAME_MS = 1000 / 15  # of the detector and the capture


def rows() -> Iterator[Row]:
    with Server() as stack, stack.serve() as url, sync_playwright() as playwright:
        visited = url.replace("127.0.0.1", HOST)  # where pages keep their files
        _, token_id, _ = DEVELOPMENT_TOKEN.split("_")
        tokens = Store.of(Settings.from_environment(stack.environment)).tokens
        tokens.update(token_id, lambda token: replace(token, origins=(*token.origins, visited)))
        yield from detector(playwright, url, visited)
        yield from capture(playwright, url)


def detector(playwright: Playwright, url: str, visited: str) -> Iterator[Row]:
    browser = playwright.chromium.launch(executable_path=chromium_path(), args=CHROMIUM)
    page = browser.new_page(base_url=url, service_workers="block")
    first = statistics.median([first_detection(page) for _ in range(4)][1:])
    page.goto("/board/")
    seen = page.evaluate(DETECTIONS, FRAMES)
    video = [calibration("rectilinear"), RATE]
    rectified = {"Chromium": page.evaluate(RECTIFIED_AT_RATE, video)}
    visitor = browser.new_page(base_url=visited)
    visitor.goto("/calibrate/")
    kept(visitor, name="opencv.wasm")
    second_visit = statistics.median(first_detection(visitor) for _ in range(3))
    browser.close()
    with firefox() as in_firefox:
        function = f"() => ({RECTIFIED_AT_RATE})({json.dumps(video)})"
        rectified["Firefox"] = in_firefox(f"{url}/board/", function)
    memory = np.array(seen["memory"]) / 1e6
    median = float(np.median(seen["elapsed"]))
    yield Row("browser: detection 1280x720, a frame", median, FRAME_MS, "ms", "15 frames/s")
    yield Row("browser: detection of the frame that is sent", seen["full"]["elapsed"], None, "ms")
    yield Row("browser: memory of the detector", memory[-1], None, "MB", f"after {FRAMES} frames")
    yield Row("browser: growth of the detector's memory", float(memory[-1] - memory[0]), 0.0, "MB")
    yield Row("browser: first detection, from cache", first, 3.0, "s")
    yield Row("browser: first detection, from the service worker", second_visit, 3.0, "s")
    for name, found in rectified.items():
        what = f"rectifier at half size, {name}"
        yield Row(f"{what}, a frame", found["median"], 1000 / RATE, "ms", f"{RATE} frames/s")
        yield Row(f"{what}, frames dropped", found["dropped"], 0.0, "of 30")


def capture(playwright: Playwright, url: str) -> Iterator[Row]:
    with tempfile.TemporaryDirectory() as folder, camera(playwright, url, Path(folder), rate=30) as page:
        pace = median_pace(page)
    yield Row("browser: time of a frame in the capture", 1000 / pace.rate, FRAME_MS, "ms", "15 frames/s")
    yield Row("browser: longest task of the page", pace.longest, 50.0, "ms", "0: none reached 50 ms")
