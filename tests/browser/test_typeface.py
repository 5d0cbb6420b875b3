"""The typeface at a first visit."""

import re

import pytest
from playwright.sync_api import Route

from tests.helpers.browser.scenes import BLIND_DETECTOR
from tests.helpers.browser.scripts import page_function
from tests.helpers.browser.site_pages import MAX_SHIFT, WATCH_SHIFTS, shifts
from tests.helpers.marks import thorough

from ..conftest import THOROUGH
from .conftest import Visitor

PATHS = ("/", "/calibrate/", "/ar/", "/rig/", "/cameras/", "/photos/")
WIDTHS = page_function("heading_widths")


@pytest.mark.parametrize("size", [(390, 844), *thorough(((1440, 900),))], ids=["phone", "laptop"])
def test_first_visits_show_the_typeface_without_a_shift(visitor: Visitor, size: tuple[int, int]) -> None:
    held: list[Route] = []
    for path in PATHS if THOROUGH else PATHS[:1]:
        page = visitor(viewport={"width": size[0], "height": size[1]}, locale="en").new_page()
        page.add_init_script(WATCH_SHIFTS + BLIND_DETECTOR)
        held.clear()
        page.route(re.compile("geologica-latin"), lambda route: held.append(route))
        page.goto(path, wait_until="domcontentloaded")
        page.locator("h1:visible").first.wait_for()
        page.evaluate("new Promise((done) => requestAnimationFrame(() => setTimeout(done)))")
        assert held, path
        for route in held:
            route.continue_()
        page.unroute_all(behavior="wait")
        page.evaluate("document.fonts.load('600 20px Geologica').then(() => null)")
        page.evaluate("new Promise((done) => requestAnimationFrame(() => setTimeout(done)))")
        moved = shifts(page)
        shown, expected, other = page.evaluate(WIDTHS)
        assert shown == pytest.approx(expected, abs=0.05), path
        assert abs(other - expected) > 1, path
        assert sum(value for value, _ in moved) < MAX_SHIFT, (path, moved)
