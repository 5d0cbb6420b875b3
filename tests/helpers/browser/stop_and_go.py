"""Real footage as a hand that stops and goes: poses of a video are held, with its own motion between."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from playwright.sync_api import Page, Playwright

from ...browser.conftest import CHROMIUM, WINDOW, chromium_path
from .waiting import TIMEOUT_S

RATE = 8  # frames/s of the camera
POSES = 16
HELD_S, MOVING_S = 2.0, 0.6


def frames_of(path: Path) -> list[Any]:
    capture = cv2.VideoCapture(str(path))
    frames = []
    while (read := capture.read())[0]:
        frames.append(read[1])
    return frames


def stop_and_go(frames: Sequence[Any]) -> Iterator[Any]:
    """Hold POSES frames, spread evenly, and let those between pass."""
    stops = [round(n * (len(frames) - 1) / (POSES - 1)) for n in range(POSES)]
    for here, there in zip(stops, [*stops[1:], stops[-1]], strict=True):
        yield from [frames[here]] * round(HELD_S * RATE)
        if there > here:
            for moment in np.linspace(here, there, round(MOVING_S * RATE), endpoint=False):
                yield frames[round(float(moment))]


def write(path: Path, frames: Iterable[Any], rate: int = RATE) -> Path:
    """Write frames as a YUV4MPEG2 file, which Chromium's camera repeats."""
    with path.open("wb") as file:
        for n, frame in enumerate(frames):
            h, w = frame.shape[:2]
            if n == 0:
                file.write(f"YUV4MPEG2 W{w} H{h} F{rate}:1 Ip A1:1 C420mpeg2\n".encode())
            file.write(b"FRAME\n" + cv2.cvtColor(frame, cv2.COLOR_BGR2YUV_I420).tobytes())
    return path


@contextmanager
def camera(playwright: Playwright, url: str, source: Path) -> Iterator[Page]:
    """Page in a Chromium whose camera is a YUV4MPEG2 file."""
    flags = [
        "--use-fake-ui-for-media-stream",
        "--use-fake-device-for-media-stream",
        f"--use-file-for-fake-video-capture={source}",
    ]
    browser = playwright.chromium.launch(executable_path=chromium_path(), args=CHROMIUM + flags)
    try:
        page = browser.new_page(base_url=url, viewport=WINDOW, service_workers="block")
        page.set_default_timeout(1000 * TIMEOUT_S)
        yield page
    finally:
        browser.close()
