"""Controls and messages of the capture page."""

import re
import time

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from tests.helpers.browser.interruptions import (
    ENDLESS,
    HIDE,
    PRACTICE,
    UNPLUG,
    views,
    wait_for_views,
)
from tests.helpers.browser.pictures import SIZES, picture
from tests.helpers.browser.scenes import BLIND_DETECTOR, LISTED_LATE, PLUG, PLUGGED
from tests.helpers.browser.scripts import page_function
from tests.helpers.browser.waiting import address, at_rest, hear, listen, requests_within, until
from tests.helpers.marks import thorough

from ..conftest import THOROUGH

# A page that waits longer for answers.
PATIENT = """
  {
    const wait = window.setTimeout;
    window.setTimeout = (call, ms, ...more) => wait(call, [2_000, 5_000].includes(ms) ? 60_000 : ms, ...more);
  }
"""
# What speaks by itself to who listens to the page.
LIVE = """() => [
  ...document.querySelectorAll("[aria-live]:not([aria-live=off]), [role=alert], [role=status]"),
  ...document.querySelectorAll("output:not([aria-live])"),
].filter((each) => each.checkVisibility()).map(({ id }) => id)"""
SENSES = """
  Object.assign(window, { notes: 0, felt: [], spoken: [] });
  const create = AudioContext.prototype.createOscillator;
  AudioContext.prototype.createOscillator = function () { window.notes += 1; return create.call(this); };
  navigator.vibrate = (ms) => window.felt.push(ms);
  speechSynthesis.speak = ({ lang, text }) => window.spoken.push([lang, text]);
"""
HEADER = "document.querySelector('header.rim').getBoundingClientRect().height"
HINTS = "[Kk]ante|halten|[Dd]rehen|Nach |heran|weg"
AMISS = page_function("viewfinder_faults")
LONGER = """(words) => {
  const height = () => document.getElementById("stage").clientHeight;
  const before = height();
  words.forEach((text, at) => {
    document.getElementById(["count", "count-more"][at]).textContent = text;
  });
  return height() - before;
}"""
# As they are held, turned, and zoomed in to 200 %.
LENGTHS = [["", ""], ["Ansicht 3 von etwa 5", " · genau genug; noch 2 zur Bestätigung"]]
# In a capture of twelve views.
LONG_FILM = """() => {
  const film = document.getElementById("film");
  while (film.children.length < 12) film.append(film.lastElementChild.cloneNode(true));
  document.getElementById("finish").hidden = false;
}"""
# From the picture's lower edge to what is to be done, px.
DOCKED = """() => {
  const [stage, video] = ["stage", "video"].map((id) => document.getElementById(id));
  const { bottom, height, width } = stage.getBoundingClientRect();
  const picture = (width * video.videoHeight) / video.videoWidth;
  const edge = bottom - (height - picture) / 2;
  return document.getElementById("instruction").getBoundingClientRect().top - edge;
}"""
WINDOWS = [(320, 480), (390, 844), (480, 320), (844, 390), (820, 1180), (1440, 900)]
if THOROUGH:
    WINDOWS += [
        (320, 640),
        (568, 320),
        (640, 360),
        (667, 375),
        (720, 450),
        (1024, 768),
        (1180, 820),
        (1280, 720),
    ]


def expect_all_in_reach(page: Page, language: str) -> None:
    """Assert that all controls are in the window and the picture stands still."""
    page.locator("#language").select_option(language)
    for width, height in WINDOWS:
        page.set_viewport_size({"width": width, "height": height})
        page.evaluate(LONG_FILM)
        amiss = page.evaluate(AMISS)
        assert amiss == [], f"{language} at {width} x {height}: {amiss}"
        if (width, height) == (390, 844):
            assert 0 <= page.evaluate(DOCKED) < 16, "where one looks, not at the far edge of the window"
        if width >= 390 and language == "de":
            for words in LENGTHS:
                moved = page.evaluate(LONGER, words)
                assert moved == 0, f"{words!r} moves the picture by {moved} px at {width} x {height}"


@pytest.mark.parametrize("seconds", [2, *thorough(60)])
def test_capture_speaks_waits_while_hidden_and_obeys_keys(page: Page, seconds: int) -> None:
    sent: list[str] = []
    page.add_init_script(PATIENT)
    listen(page)
    page.set_viewport_size(SIZES["hand"])
    page.goto(f"{ENDLESS}&error=4&camera=Another+one&lang=en", wait_until="domcontentloaded")
    height = page.evaluate(HEADER)
    page.locator("#instruction:focus").wait_for()
    page.locator("#sent:visible").wait_for()
    assert page.evaluate(HEADER) == pytest.approx(height, abs=0.5)
    hear(page, "another", "Expected: Another one.*Open now: calibDB virtual camera")
    hear(page, "said", "Expected: Another one")
    assert page.evaluate(LIVE) == ["said"]
    page.locator("#undo:enabled").wait_for()
    expect(page.locator("#another")).to_be_hidden()

    page.locator("#language").select_option("de")
    expect(page.locator("#stop")).to_have_text("Beenden")
    expect(page.locator("#counts")).to_contain_text("Ansicht")
    hear(page, "said", HINTS)
    with at_rest(page):
        page.evaluate(HIDE, True)  # as if in the background, so that no view is the last one
    hidden_at = time.monotonic()
    page.on("request", lambda request: sent.append(request.url) if "/v1/" in request.url else None)
    for language in ("de", "uk") if THOROUGH else ("de",):
        expect_all_in_reach(page, language)
    page.locator("#language").select_option("en")

    popover = page.locator("#senses")
    popover.locator("summary").click()
    page.keyboard.press("Escape")
    assert popover.get_attribute("open") is None
    assert page.evaluate("document.activeElement.parentElement.id") == "senses"
    popover.locator("summary").click()
    page.locator("#stage").click()
    assert popover.get_attribute("open") is None
    page.keyboard.press("Escape")
    expect(page.locator("#controls"), "no key ends a capture by accident").to_be_visible()

    assert requests_within(page, max(0.1, seconds - (time.monotonic() - hidden_at))) == []
    assert sent == []

    assert views(page) >= 1
    page.locator("#undo").focus()
    # At the first view the button is disabled, and the focus goes on; after that it stays.
    with at_rest(page), page.expect_response(lambda response: response.request.method == "DELETE") as undone:
        page.keyboard.press("u")
    assert undone.value.status == 200
    hear(page, "notice", "^The last view was undone.$")
    page.locator("#instruction:focus, #undo:enabled:focus").wait_for()
    with page.expect_response(lambda response: "skip=1" in response.url) as skipped:
        page.keyboard.press("N")
    assert skipped.value.status == 200
    before = views(page)
    page.evaluate(HIDE, False)
    hear(page, "notice", "No views were taken while this page was hidden")
    wait_for_views(page, before + 1)

    page.add_init_script(BLIND_DETECTOR)  # there are views enough
    page.goto("/calibrate/?lang=de")
    page.locator("#interrupted-text", has_text="gespeichert").wait_for()
    picture(page, "capture-interrupted", ["hand"])
    page.locator("#go-on", has_text="Fortfahren").click()
    page.locator("#controls:not([hidden])").wait_for()
    expect(page.locator("#stop")).to_have_text("Beenden")
    assert "/de/calibrate/?" in address(page)
    page.evaluate(UNPLUG)
    page.locator("#failed-title:focus").wait_for()
    page.locator("#other").click()
    page.locator("#welcome-title:focus").wait_for()
    page.locator("#forget").click()
    page.locator("#interrupted").wait_for(state="hidden")


def test_requested_camera_is_opened_and_refusals_are_explained(
    page: Page,
) -> None:
    page.add_init_script(PLUGGED + LISTED_LATE + BLIND_DETECTOR)
    listen(page)
    page.goto("/calibrate/?camera=HD+Pro+Webcam+C920+(046d:082d)")
    page.locator("#settings > summary").click()
    page.locator("#resolution").select_option("1920 × 1080")
    expect(page.locator("#setup")).to_contain_text("1920 × 1080")
    page.locator("#start").click()
    expect(page.locator("#camera option"), "nothing is said before it is known").to_have_count(0)
    expect(page.locator("#wanted")).to_have_text("This page was opened for HD Pro Webcam C920 (046d:082d).")
    page.evaluate("window.answer()")
    hear(page, "notice", "The camera delivers 1280 × 720, so this page calibrates that size.")
    asked = page.evaluate("window.asked")
    assert asked["deviceId"] == {"exact": "0"}
    assert (asked["width"], asked["height"]) == ({"ideal": 1920}, {"ideal": 1080})
    assert asked["resizeMode"] == "none"
    page.evaluate(PLUG, False)
    page.evaluate(UNPLUG)
    page.locator("#failure", has_text="The camera was unplugged. Plug it in again").wait_for()
    page.evaluate(PLUG, True)
    page.locator("#controls:not([hidden])").wait_for()

    page.locator("#stop").click()
    refusals = (
        ("#start", "NotAllowedError", "Camera access is blocked. Click the camera icon in the address bar"),
        ("#again", "NotReadableError", "Another program is using the camera. Close it, then try again."),
        ("#again", "NotFoundError", "No camera was found. Plug one in, or try a simulated camera."),
    )
    for button, refusal, said in refusals:
        page.evaluate("(refusal) => { window.refusal = refusal; }", refusal)
        page.locator(button).click()
        page.locator("#failure", has_text=said).wait_for()
        expect(page.locator("#failed-virtual")).to_be_visible(visible=refusal == "NotFoundError")
    page.evaluate("window.refusal = ''")
    page.locator("#again").click()
    page.locator("#controls:not([hidden])").wait_for()


def test_who_has_no_camera_is_told_and_may_practise(context: BrowserContext) -> None:
    page = context.new_page()
    page.add_init_script(BLIND_DETECTOR)
    page.goto(PRACTICE)
    page.locator("#wanted", has_text="No camera was found. Plug one in, or try").wait_for()
    expect(page.locator("#start-virtual.primary")).to_be_visible()
    picture(page, "capture-no-camera", ["hand"], check=THOROUGH)
    page.locator("#settings > summary").click()
    expect(page.locator("#resolutions")).to_be_visible()
    page.locator("#camera").select_option("virtual")
    expect(page.locator("#resolutions")).to_be_hidden()
    page.locator("#start").click()
    page.locator("#opening:not([hidden]), #controls:not([hidden])").wait_for()
    page.locator("#practice").wait_for(state="attached")
    page.locator("#facts", has_text="calibDB virtual camera").wait_for()


@pytest.mark.thorough
def test_a_view_is_heard_and_felt_and_hints_are_spoken(page: Page) -> None:
    page.add_init_script(SENSES)
    page.goto(f"{ENDLESS}&lang=de")
    page.locator("#controls:not([hidden])").wait_for()
    page.locator("#senses summary").click()
    assert page.evaluate("window.spoken") == []
    page.locator("#voice").check()
    wait_for_views(page, views(page) + 1)
    # Sounded, shaken and said in the task in which the view is counted, or when what was said before is.
    assert page.evaluate("window.notes") >= 2
    assert 60 in page.evaluate("window.felt")
    until(page, lambda: any(re.search(HINTS, text) for _, text in page.evaluate("window.spoken")))
    assert {language for language, _ in page.evaluate("window.spoken")} == {"de"}
    for sense in ("sound", "vibration", "voice"):
        page.locator(f"#{sense}").uncheck()
    page.evaluate("() => { window.notes = 0; window.felt.length = 0; window.spoken.length = 0; }")
    wait_for_views(page, views(page) + 1)
    assert page.evaluate("[window.notes, window.felt, window.spoken]") == [0, [], []]
