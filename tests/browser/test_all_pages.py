"""All pages, sizes and languages: stable layout, nothing cut, accessible."""

import re
from typing import Literal

import pytest
from playwright.sync_api import Route

from tests.helpers.browser.pictures import FINGER, INLINE, SMALL, violations
from tests.helpers.browser.scenes import BLIND_DETECTOR
from tests.helpers.browser.scripts import page_function
from tests.helpers.browser.site_pages import (
    FILLED_IN,
    MAX_SHIFT,
    ONLY_HERE,
    SIZES,
    VISITED,
    WATCH_SHIFTS,
    faults,
    prepare,
    shifts,
    unheard,
    visit,
)
from tests.helpers.marks import thorough

from ..conftest import THOROUGH
from .conftest import OUTPUT, Visitor

Scheme = Literal["light", "dark"]
OTHERS: list[tuple[str, Scheme]] = [
    ("en", "light"),
    ("en", "dark"),
    ("de", "light"),
    ("de", "dark"),
    ("uk", "light"),
]


ENDLESS = """() => document.getAnimations()
  .filter(({ playState, effect }) => playState === "running" && effect?.getTiming().iterations === Infinity)
  .map(({ effect }) => effect.target?.outerHTML.slice(0, 80))"""


#: looked at in both themes in make test; what the guide of the API shows is in the reference of a call, too
OTHER_THEME = set(ONLY_HERE) - {"reference"}


#: the longest words in make test
@pytest.mark.parametrize(("language", "scheme"), [("uk", "dark"), *thorough(*OTHERS)])
def test_pages_stand_still_fit_and_are_accessible(visitor: Visitor, language: str, scheme: Scheme) -> None:
    """On a phone; `make thorough`: at every size, in both themes. Colours are all that a theme changes."""
    page = visitor().new_page()
    session = prepare(page)
    found = []
    for name in VISITED:
        for opened in SIZES if THOROUGH else (390,):
            page.emulate_media(color_scheme=scheme, reduced_motion="no-preference")
            page.set_viewport_size(SIZES[opened])
            visit(page, session, name, language)
            moved = shifts(page)
            amiss = unheard(page)
            if (THOROUGH or name in FILLED_IN) and sum(value for value, _ in moved) >= MAX_SHIFT:
                amiss.append(f"moves {moved}")
            for width in (opened,) if THOROUGH else (320,):
                amiss += [f"at {width} px: {fault}" for fault in faults(page, width)]
            # Those that are filled in are held to the other rules by tests of their own.
            rules = () if THOROUGH or name in ONLY_HERE else ("color-contrast",)
            amiss += violations(page, *rules)
            amiss += page.evaluate(SMALL, [FINGER, INLINE]) if not THOROUGH or opened < 768 else []
            if THOROUGH:
                OUTPUT.mkdir(exist_ok=True)
                page.screenshot(path=OUTPUT / f"all-{name}-{opened}-{language}-{scheme}.png", full_page=True)
            other: Scheme = "light" if scheme == "dark" else "dark"
            page.emulate_media(color_scheme=other, reduced_motion="reduce")
            amiss += page.evaluate(ENDLESS)
            amiss += violations(page, "color-contrast") if THOROUGH or name in OTHER_THEME else []
            found += [f"{name} at {opened}: {each}" for each in amiss]
    assert not found, "\n".join(found)


FIRST_VISITS = ("/", "/calibrate/", "/ar/", "/rig/", "/cameras/", "/photos/")
WIDTHS = page_function("heading_widths")


@pytest.mark.parametrize("size", [(390, 844), *thorough(((1440, 900),))], ids=["phone", "laptop"])
def test_first_visits_show_the_typeface_without_a_shift(visitor: Visitor, size: tuple[int, int]) -> None:
    held: list[Route] = []
    for path in FIRST_VISITS if THOROUGH else FIRST_VISITS[:1]:
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
