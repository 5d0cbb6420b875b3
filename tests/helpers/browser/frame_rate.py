"""Frame rate, longest task and first detection of the capture page; dropped frames of the rectifier."""

import statistics
from dataclasses import dataclass

from playwright.sync_api import Page

from .scripts import page_function

COUNT_FRAMES = """
  window.looks = 0;
  window.Worker = class extends Worker {
    postMessage(message, transfer) {
      if (message.frame) window.looks += 1;
      super.postMessage(message, transfer);
    }
  };
"""
WATCH_TASKS = """
  window.tasks = [];
  new PerformanceObserver((list) => {
    for (const { startTime, duration } of list.getEntries()) window.tasks.push([startTime, duration]);
  }).observe({ type: "longtask" });
"""
MEASURE = """async (ms) => {
  window.looks = 0;
  const start = performance.now();
  await new Promise((done) => setTimeout(done, ms));
  const [end, { looks, tasks }] = [performance.now(), window];
  await new Promise((done) => setTimeout(done, 100)); // tasks are told of a little later
  const own = tasks.filter(([begun]) => begun > start && begun < end).map(([, duration]) => duration);
  return { rate: (1000 * looks) / (end - start), longest: Math.max(0, ...own) };
}"""
RECTIFIED_AT_RATE = page_function("rectify_at_rate")


@dataclass(frozen=True)
class Pace:
    """Detections per second; the page's longest task, ms, 0 if none took 50 ms."""

    rate: float
    longest: float


def start(page: Page) -> None:
    """Start a capture that does not converge."""
    page.add_init_script(COUNT_FRAMES + WATCH_TASKS)
    page.goto("/calibrate/?target_error=0.001")
    page.locator("#camera option").nth(1).wait_for(state="attached")
    page.locator("#start").click()
    page.locator("#controls:not([hidden])").wait_for()
    page.locator(".corner").first.wait_for(state="attached")


def median_pace(page: Page) -> Pace:
    """Median of each figure over three windows of a capture, 3 s each."""
    start(page)
    paces = [page.evaluate(MEASURE, 3_000) for _ in range(3)]
    return Pace(*(statistics.median(pace[name] for pace in paces) for name in ("rate", "longest")))


def first_detection(page: Page) -> float:
    """Seconds from navigation to the first detection."""
    page.goto("/calibrate/?virtual=1")
    page.locator(".corner").first.wait_for(state="attached")
    mark: float = page.evaluate("performance.getEntriesByName('first detection')[0].startTime")
    return mark / 1000
