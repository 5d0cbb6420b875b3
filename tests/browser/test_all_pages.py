"""All pages, all sizes, all languages: nothing moves while they appear, nothing is cut, all lead on."""

import pytest

from tests.helpers.browser.pictures import FINGER, INLINE, SMALL, violations
from tests.helpers.browser.site_pages import (
    FILLED_IN,
    MAX_SHIFT,
    PAGES,
    SIZES,
    faults,
    prepare,
    shifts,
    visit,
)
from tests.helpers.marks import thorough

from ..conftest import THOROUGH
from .conftest import OUTPUT, Visitor

OTHERS = [("en", "light"), ("en", "dark"), ("de", "light"), ("de", "dark"), ("uk", "light")]


#: the longest words in make test
@pytest.mark.parametrize(("language", "scheme"), [("uk", "dark"), *thorough(*OTHERS)])
def test_pages_stand_still_and_fit(visitor: Visitor, language: str, scheme: str) -> None:
    """Those that scripts fill in, on a phone; `make thorough`: all of them at every size, with axe."""
    page = visitor(color_scheme=scheme).new_page()
    prepare(page)
    found = []
    for name in PAGES if THOROUGH else FILLED_IN:
        for opened in SIZES if THOROUGH else (390,):
            page.set_viewport_size(SIZES[opened])
            visit(page, name, language)
            moved = shifts(page)
            if sum(value for value, _ in moved) >= MAX_SHIFT:
                found.append(f"{name} at {opened}: moves {moved}")
            for width in (opened,) if THOROUGH else (320, 2560):
                found += [f"{name} at {width}: {fault}" for fault in faults(page, width)]
            if THOROUGH:
                small = page.evaluate(SMALL, [FINGER, INLINE]) if opened < 768 else []
                found += [f"{name} at {opened}: {each}" for each in (*violations(page), *small)]
                OUTPUT.mkdir(exist_ok=True)
                page.screenshot(path=OUTPUT / f"all-{name}-{opened}-{language}-{scheme}.png", full_page=True)
    assert not found, "\n".join(found)


# What moves without end
ENDLESS = """() => document.getAnimations()
  .filter(({ playState, effect }) => playState === "running" && effect?.getTiming().iterations === Infinity)
  .map(({ effect }) => effect.target?.outerHTML.slice(0, 80))"""


def test_every_page_is_accessible_in_both_themes_and_fits_the_smallest_window(visitor: Visitor) -> None:
    """Colours are all that a theme changes."""
    page = visitor(viewport=SIZES[320], reduced_motion="reduce").new_page()
    prepare(page)
    found = []
    for name in PAGES:
        page.emulate_media(color_scheme="light")
        visit(page, name, "en")
        amiss = [*faults(page, 320), *page.evaluate(ENDLESS), *violations(page)]
        amiss += page.evaluate(SMALL, [FINGER, INLINE])
        page.emulate_media(color_scheme="dark")
        amiss += violations(page, "color-contrast")
        found += [f"{name}: {each}" for each in amiss]
    assert not found, "\n".join(found)
