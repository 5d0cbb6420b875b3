"""Frame rate, longest task and first detection of the capture page; dropped frames of the rectifier.

`make bench` measures them. No test asserts them: a busy machine is not a fault of the page.
"""

from __future__ import annotations

import statistics
from dataclasses import dataclass

from playwright.sync_api import Page

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
RECTIFIED_AT_RATE = """async ([calibration, rate]) => {
  const { Rectifier } = await import("/sdk/rectifier.js");
  const source = document.createElement("canvas");
  [source.width, source.height] = calibration.img_size;
  const paint = source.getContext("2d", { alpha: false });
  document.body.append(source);
  let frame = 0;
  const painter = setInterval(() => {
    paint.fillStyle = `hsl(${frame++ * 7} 80% 50%)`;
    paint.fillRect((frame * 13) % 1200, (frame * 29) % 600, 80, 120);
  }, 1000 / rate);
  const video = document.createElement("video");
  video.muted = true;
  video.srcObject = source.captureStream(30);
  await video.play();
  const rectifier = new Rectifier(calibration, { scale: 0.5 });
  const gl = rectifier.canvas.getContext("webgl2");
  const [shown, spent] = [[], []];
  await new Promise((done) => {
    const next = (now, { presentedFrames }) => {
      const start = performance.now();
      rectifier.draw(video);
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4)); // until it is drawn
      spent.push(performance.now() - start);
      shown.push(presentedFrames);
      if (shown.length < 30) video.requestVideoFrameCallback(next);
      else done();
    };
    video.requestVideoFrameCallback(next);
  });
  clearInterval(painter);
  source.remove();
  rectifier.dispose();
  const dropped = shown.at(-1) - shown[0] + 1 - shown.length;
  return { dropped, median: spent.sort((a, b) => a - b)[spent.length >> 1] };
}"""


@dataclass(frozen=True)
class Pace:
    """Of one while: detections a second; the page's longest task, ms, 0 where none took 50 ms."""

    rate: float
    longest: float


def start(page: Page) -> None:
    """Start a capture that does not converge."""
    page.add_init_script(WATCH)
    page.goto("/calibrate/?target_error=0.001")
    page.locator("#camera option").nth(1).wait_for(state="attached")
    page.locator("#start").click()
    page.locator("#controls:not([hidden])").wait_for()
    page.locator(".corner").first.wait_for(state="attached")


def median_pace(page: Page, windows: int = 3, ms: int = 3_000) -> Pace:
    """Measure windows of a capture; return the median of each figure."""
    start(page)
    paces = [Pace(**page.evaluate(MEASURE, ms)) for _ in range(windows)]
    return Pace(
        rate=statistics.median(pace.rate for pace in paces),
        longest=statistics.median(pace.longest for pace in paces),
    )


def first_detection(page: Page) -> float:
    """Seconds from navigation to the first frame looked at."""
    page.goto("/calibrate/?virtual=1")
    page.locator(".corner").first.wait_for(state="attached")
    mark: float = page.evaluate("performance.getEntriesByName('first detection')[0].startTime")
    return mark / 1000
