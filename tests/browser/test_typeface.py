"""The typeface of the pages at a first visit, before anything is cached."""

import re

import pytest
from playwright.sync_api import Page, Route

from tests.helpers.browser.scenes import BLIND_DETECTOR
from tests.helpers.browser.scripts import page_function
from tests.helpers.marks import thorough

from ..conftest import THOROUGH
from .conftest import Visitor

PATHS = ("/", "/calibrate/", "/ar/", "/rig/", "/cameras/", "/photos/")
MAX_SHIFT = 0.01
# CLS: the largest sum of shifts within 5 s that follow one another within 1 s
SHIFTS = """window.shift = 0;
window.sources = [];
let [sum, first, last] = [0, -Infinity, -Infinity];
new PerformanceObserver((list) => {
  for (const { value, startTime, sources } of list.getEntries()) {
    if (startTime - last > 1000 || startTime - first > 5000) [sum, first] = [0, startTime];
    [sum, last] = [sum + value, startTime];
    window.shift = Math.max(window.shift, sum);
    window.sources.push(`${value.toFixed(4)} ${sources.map(({ node }) => node?.id || node?.nodeName)}`);
  }
}).observe({ type: "layout-shift", buffered: true });"""
WIDTHS = page_function("heading_widths")


def hold(page: Page, held: list[Route]) -> None:
    page.route(re.compile("geologica-latin"), lambda route: held.append(route))


@pytest.mark.parametrize("size", [(390, 844), *thorough(((1440, 900),))], ids=["phone", "laptop"])
def test_first_visits_show_the_typeface_without_a_shift(visitor: Visitor, size: tuple[int, int]) -> None:
    for path in PATHS if THOROUGH else PATHS[:1]:
        page = visitor(viewport={"width": size[0], "height": size[1]}, locale="en").new_page()
        page.add_init_script(SHIFTS + BLIND_DETECTOR)
        held: list[Route] = []
        hold(page, held)
        page.goto(path, wait_until="domcontentloaded")
        page.locator("h1:visible").first.wait_for()
        page.evaluate("new Promise((done) => requestAnimationFrame(() => setTimeout(done)))")
        assert held, path
        for route in held:
            route.continue_()
        page.unroute_all(behavior="wait")
        page.evaluate("document.fonts.load('600 20px Geologica').then(() => null)")
        page.evaluate("new Promise((done) => requestAnimationFrame(() => setTimeout(done)))")
        shift, sources = page.evaluate("[window.shift, window.sources]")
        shown, expected, other = page.evaluate(WIDTHS)
        assert shown == pytest.approx(expected, abs=0.05), path
        assert abs(other - expected) > 1, path
        assert shift < MAX_SHIFT, (path, sources)
