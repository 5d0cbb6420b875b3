"""All pages, all sizes, all languages: nothing moves while they appear, nothing is cut, all lead on."""

from __future__ import annotations

import os

import pytest
from playwright.sync_api import Browser

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
from tests.helpers.browser.waiting import TIMEOUT_S

from .conftest import OUTPUT, close

THOROUGH = bool(os.environ.get("THOROUGH"))
#: longest words, and the smallest window that is common
CASES = [
    pytest.param(
        language, scheme, marks=[] if (language, scheme) == ("uk", "dark") else [pytest.mark.thorough]
    )
    for language in ("en", "de", "uk")
    for scheme in ("light", "dark")
]


@pytest.mark.parametrize(("language", "scheme"), CASES)
def test_pages_stand_still_and_fit(chromium: Browser, stack: str, language: str, scheme: str) -> None:
    """Those that scripts fill in, on a phone; `make thorough`: all of them at every size, with axe."""
    found = []
    for name in PAGES if THOROUGH else FILLED_IN:
        for opened in SIZES if THOROUGH else (390,):
            context = chromium.new_context(
                base_url=stack,
                viewport=SIZES[opened],
                color_scheme="dark" if scheme == "dark" else "light",
                service_workers="block",
            )
            context.set_default_timeout(1000 * TIMEOUT_S)
            page = context.new_page()
            prepare(page)
            visit(page, name, language)
            moved = shifts(page)
            if sum(value for value, _ in moved) >= MAX_SHIFT:
                found.append(f"{name} at {opened}: moves {moved}")
            for width in (opened,) if THOROUGH else (320, 2560):
                found += [f"{name} at {width}: {fault}" for fault in faults(page, width)]
            if THOROUGH:
                found += [f"{name} at {opened}: {each}" for each in violations(page)]
                if opened < 768:
                    found += [
                        f"{name} at {opened}: {each}" for each in page.evaluate(SMALL, [FINGER, INLINE])
                    ]
                OUTPUT.mkdir(exist_ok=True)
                page.screenshot(path=OUTPUT / f"all-{name}-{opened}-{language}-{scheme}.png", full_page=True)
            close(context)
    assert not found, "\n".join(found)


# What moves without end
ENDLESS = """() => document.getAnimations()
  .filter(({ playState, effect }) => playState === "running" && effect?.getTiming().iterations === Infinity)
  .map(({ effect }) => effect.target?.outerHTML.slice(0, 80))"""


def test_every_page_is_accessible_in_both_themes_and_fits_the_smallest_window(
    chromium: Browser, stack: str
) -> None:
    """Colours are all that a theme changes."""
    context = chromium.new_context(
        base_url=stack, viewport=SIZES[320], service_workers="block", reduced_motion="reduce"
    )
    context.set_default_timeout(1000 * TIMEOUT_S)
    page = context.new_page()
    prepare(page)
    found = []
    for name in PAGES:
        page.emulate_media(color_scheme="light")
        visit(page, name, "en")
        amiss = [*faults(page, 320), *page.evaluate(ENDLESS), *violations(page)]
        page.emulate_media(color_scheme="dark")
        amiss += violations(page, "color-contrast")
        found += [f"{name}: {each}" for each in amiss]
    close(context)
    assert not found, "\n".join(found)
