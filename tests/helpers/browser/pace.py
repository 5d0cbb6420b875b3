"""How pages keep up: frames a second, the longest task, how soon a board is seen; on whatever machine.

Each budget is tried until it is kept, since others may be at work meanwhile, and a machine that is slower
than usual has that much more time: what is held to them is the page, not the machine.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from playwright.sync_api import Page, Playwright

from ...browser.conftest import CHROMIUM, executable
from .waiting import PATIENCE

WIDTH, HEIGHT = 1280, 720
SQUARE = 80  # texture pixels
WATCH = """
  window.pace = { frames: 0, tasks: [] };
  new PerformanceObserver((list) => {
    for (const { startTime, duration } of list.getEntries()) window.pace.tasks.push([startTime, duration]);
  }).observe({ type: "longtask" });
  window.Worker = class extends Worker {
    postMessage(message, transfer) {
      if (message.frame) window.pace.frames += 1;
      super.postMessage(message, transfer);
    }
  };
"""
MEASURE = """async (ms) => {
  window.pace.frames = 0;
  const start = performance.now();
  await new Promise((done) => setTimeout(done, ms));
  const [end, { frames, tasks }] = [performance.now(), window.pace];
  await new Promise((done) => setTimeout(done, 100)); // tasks are told of a little later
  const own = tasks.filter(([begun]) => begun > start && begun < end).map(([, duration]) => duration);
  return { rate: (1000 * frames) / (end - start), longest: Math.max(0, ...own) };
}"""
WORK = """async () => {
  const values = new Float64Array(4096);
  const taken = [];
  for (let time = 0; time < 5; time++) {
    await new Promise((done) => setTimeout(done));
    const start = performance.now();
    for (let at = 0; at < 8_000_000; at++) values[at & 4095] = Math.sqrt(values[(at * 7) & 4095] + at);
    taken.push(performance.now() - start);
  }
  return taken.sort((a, b) => a - b)[2];
}"""
USUAL = 16.0  # ms that this work takes where nothing else is done
TRIES = 10


@dataclass(frozen=True)
class Pace:
    """Of one while: detections a second; the page's longest task, ms, 0 where none took 50 ms."""

    rate: float
    longest: float


def board_seen() -> tuple[np.ndarray, np.ndarray]:
    """Grey picture of the default board as OpenCV draws it, tilted, and where its corners are, (40, 2)."""
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    board = cv2.aruco.CharucoBoard((9, 6), 1, 0.65, dictionary)
    texture = board.generateImage((11 * SQUARE, 8 * SQUARE), marginSize=SQUARE)
    matrix = np.array([[1000, 0, 640], [0, 1000, 360], [0, 0, 1.0]])
    rotation, translation = np.array([0.25, -0.45, 0.05]), np.array([-4.0, -2.8, 10.0])
    plane = matrix @ np.column_stack([cv2.Rodrigues(rotation)[0][:, :2], translation])
    # Texture pixel → board: the origin is the edge of the first square, half a pixel before its centre.
    to_board = np.array([[1 / SQUARE, 0, 0.5 / SQUARE - 1], [0, 1 / SQUARE, 0.5 / SQUARE - 1], [0, 0, 1]])
    picture = cv2.warpPerspective(
        texture,
        plane @ to_board,
        (WIDTH, HEIGHT),
        flags=cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=120,
    )
    corners = np.array([(x, y, 0.0) for y in range(1, 6) for x in range(1, 9)])
    points = cv2.projectPoints(corners, rotation, translation, matrix, None)[0].reshape(-1, 2)
    return cv2.GaussianBlur(picture, (0, 0), 0.7), points


def video(path: Path, grey: np.ndarray, rate: int) -> Path:
    """Write one picture as a YUV4MPEG2 file, which Chromium shows over and over."""
    luma = (16 + grey.astype(np.float64) * (219 / 255)).round().astype(np.uint8).tobytes()
    chroma = bytes([128]) * (WIDTH * HEIGHT // 2)
    with path.open("wb") as file:
        file.write(f"YUV4MPEG2 W{WIDTH} H{HEIGHT} F{rate}:1 Ip A1:1 C420mpeg2\n".encode())
        for _ in range(4):
            file.write(b"FRAME\n" + luma + chroma)
    return path


@contextmanager
def camera(playwright: Playwright, url: str, folder: Path, rate: int = 20) -> Iterator[Page]:
    """Give a page in a Chromium whose camera shows a board."""
    source = video(folder / "board.y4m", board_seen()[0], rate)
    flags = [
        "--use-fake-ui-for-media-stream",
        "--use-fake-device-for-media-stream",
        f"--use-file-for-fake-video-capture={source}",
    ]
    browser = playwright.chromium.launch(executable_path=executable("chromium"), args=CHROMIUM + flags)
    try:
        page = browser.new_page(base_url=url, service_workers="block")
        page.set_default_timeout(1000 * PATIENCE)
        yield page
    finally:
        browser.close()


def slowness(page: Page) -> float:
    """How many times as long as usual a page takes for its work now; 1 at least."""
    return max(1.0, page.evaluate(WORK) / USUAL)


def start(page: Page) -> None:
    """Let the page capture with its camera, for ever."""
    page.add_init_script(WATCH)
    page.goto("/calibrate/?target_error=0.001")
    page.locator("#camera option").nth(1).wait_for(state="attached")
    page.locator("#start").click()
    page.locator("#controls:not([hidden])").wait_for()
    page.locator(".corner").first.wait_for(state="attached")


def best_pace(page: Page, windows: int = 3, ms: int = 3_000) -> Pace:
    """Measure a few whiles of a capture; give the best of each."""
    start(page)
    paces = [Pace(**page.evaluate(MEASURE, ms)) for _ in range(windows)]
    return Pace(rate=max(pace.rate for pace in paces), longest=min(pace.longest for pace in paces))


def pace_kept(page: Page, rate: float, longest: float, ms: int = 2_000) -> Pace:
    """Measure whiles of a capture until it keeps up in one; give the last one, as of a machine as usual."""
    start(page)
    for _ in range(TRIES):
        slow = slowness(page)
        seen = Pace(**page.evaluate(MEASURE, ms))
        print(f"{seen}; longest task 0: none of 50 ms; {slow:.1f} x slow")
        pace = Pace(rate=seen.rate * slow, longest=seen.longest / slow)
        if pace.rate >= rate and pace.longest < longest:
            break
    return pace


def first_detection(page: Page) -> float:
    """Seconds from navigation to the first frame looked at."""
    page.goto("/calibrate/?virtual=1")
    page.locator(".corner").first.wait_for(state="attached")
    mark: float = page.evaluate("performance.getEntriesByName('first detection')[0].startTime")
    return mark / 1000


def detection_kept(page: Page, within: float) -> float:
    """Open the page until it looks soon enough; give what it took last, s, as of a machine as usual."""
    for _ in range(TRIES):
        seconds, slow = first_detection(page), slowness(page)
        print(f"first detection {seconds:.2f} s after navigation; {slow:.1f} x slow")
        page.goto("/board/")
        if seconds / slow < within:
            break
    return seconds / slow
