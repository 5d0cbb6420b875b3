"""Pictures of pages at a desk, on a tablet and in a hand, and what is wrong with them."""

from collections.abc import Iterable

from playwright.sync_api import Page, ViewportSize

from .conftest import OUTPUT, ROOT

AXE = ROOT / "node_modules" / "axe-core" / "axe.min.js"
SIZES: dict[str, ViewportSize] = {
    "desk": {"width": 1440, "height": 900},
    "tablet": {"width": 820, "height": 1180},
    "hand": {"width": 390, "height": 844},
}
FINGER = 44  # px, WCAG 2.5.5
INLINE = 24  # px, WCAG 2.5.8: within a line of text

# What can be touched, and is smaller than a finger. A label counts for its box.
SMALL = """([finger, inline]) => {
  const touched = document.querySelectorAll("a[href], button, select, input, summary");
  return [...touched].flatMap((element) => {
    const target = element.closest("label") ?? element;
    const { width, height } = target.getBoundingClientRect();
    if (width === 0 || !element.checkVisibility({ visibilityProperty: true })) return [];
    const least = getComputedStyle(target).display === "inline" ? inline : finger;
    return height + 0.5 < least || width + 0.5 < inline
      ? [`${element.outerHTML.slice(0, 120)}: ${width.toFixed(0)} x ${height.toFixed(0)}`] : [];
  });
}"""


def violations(page: Page) -> list[str]:
    # Evaluated rather than added as a script: the policy of the pages rightly refuses that.
    page.evaluate(f"() => {{ if (!window.axe) {{ {AXE.read_text()} }} }}")
    found = page.evaluate("async () => (await window.axe.run()).violations")
    return [f"{v['id']}: {v['help']}: {[n['html'] for n in v['nodes']]}" for v in found]


def picture(
    page: Page, name: str, sizes: Iterable[str] = ("desk", "hand"), *, full: bool = False, check: bool = True
) -> None:
    """Take pictures of a state, and hold it to what holds for all: no sideways scrolling, axe, fingers."""
    OUTPUT.mkdir(exist_ok=True)
    for size in sizes:
        viewport = SIZES[size]
        page.set_viewport_size(viewport)
        page.wait_for_timeout(150)
        page.screenshot(path=OUTPUT / f"{name}-{size}.png", full_page=full)
        if not check:
            continue
        wide = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
        assert wide <= 0, f"{name} is {wide} px too wide at {viewport['width']}"
        found = violations(page)
        assert found == [], found
        small = page.evaluate(SMALL, [FINGER, INLINE])
        assert small == [], small
