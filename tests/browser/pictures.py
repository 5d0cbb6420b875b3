"""Pictures of pages at a desk and in a hand, and what axe-core finds wrong with them."""

from playwright.sync_api import Page

from .conftest import OUTPUT, ROOT

AXE = ROOT / "node_modules" / "axe-core" / "axe.min.js"
SIZES = {"desk": {"width": 1440, "height": 900}, "hand": {"width": 390, "height": 844}}


def violations(page: Page) -> list[str]:
    # Evaluated rather than added as a script: the policy of the pages rightly refuses that.
    page.evaluate(f"() => {{ if (!window.axe) {{ {AXE.read_text()} }} }}")
    found = page.evaluate("async () => (await window.axe.run()).violations")
    return [f"{v['id']}: {v['help']}: {[n['html'] for n in v['nodes']]}" for v in found]


def picture(page: Page, name: str) -> None:
    OUTPUT.mkdir(exist_ok=True)
    for size, viewport in SIZES.items():
        page.set_viewport_size(viewport)
        page.wait_for_timeout(150)
        page.screenshot(path=OUTPUT / f"{name}-{size}.png", full_page=name == "landing")
        wide = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
        assert wide <= 0, f"{name} is {wide} px too wide at {viewport['width']}"
        found = violations(page)
        assert found == [], found
