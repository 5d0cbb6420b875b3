"""Diagnosis of pictures in which the board is not seen, or not well."""

import json

import pytest
from playwright.sync_api import Page, expect

from tests.helpers.browser.pictures import picture
from tests.helpers.browser.truth import SMALL
from tests.helpers.browser.waiting import address, hear, listen


def capture_page(**more: object) -> str:
    return f"/calibrate/?{SMALL.query(error=0, **more)}"


WATCH = """async (faults) => {
  const { DEFAULT_BOARD } = await import("/lib/board.js");
  const { Painter } = await import("/lib/virtual/painter.js");
  const { degrade } = await import("/lib/virtual/degrade.js");
  const { Detector } = await import("/lib/detector.js");
  const { HEALTHY, diagnose, nextProbe } = await import("/lib/capture/diagnosis.js");
  const size = [1280, 720];
  const lens = { fx: 1000, fy: 1000, cx: 664.5, cy: 359.5, k1: -0.25, k2: 0, p1: 0, p2: 0, k3: 0 };
  const detector = await Detector.open(DEFAULT_BOARD);
  const painters = new Map();
  const painterOf = (board) => {
    const name = JSON.stringify(board);
    if (!painters.has(name)) painters.set(name, new Painter({ ...DEFAULT_BOARD, ...board }, lens, size));
    return painters.get(name);
  };
  const said = {};
  for (const [name, { fault, board = {}, z = 9 }] of Object.entries(faults)) {
    const picture = new ImageData(...size);
    const pose = { rvec: [0.35, -0.45, 0.1], tvec: [-4, -3, z] };
    painterOf(board).paint(pose, picture.data);
    if (fault) degrade(picture, fault);
    const found = new Map(); // of one picture, for the same question, it is always the same
    let state = HEALTHY;
    for (let time = 1000; time < 16000 && !state.trouble; time += 250) {
      const probe = nextProbe(state, time);
      if (!found.has(probe)) {
        const frame = await createImageBitmap(picture);
        found.set(probe, await detector.detect(frame, { probe, timeout: 120_000 }));
      }
      state = diagnose(state, found.get(probe), 0, time);
    }
    said[name] = state.trouble;
  }
  detector.close();
  return said;
}"""


def test_each_trouble_is_known_from_the_picture(page: Page) -> None:
    faults = {
        "nothing": {},
        "dark": {"fault": "dark"},
        "bright": {"fault": "bright"},
        "blurred": {"fault": "blurred"},
        "moire": {"fault": "moire"},
        "mirrored": {"fault": "mirrored"},
        "far": {"z": 57},
        "wrong_board": {"board": {"dictionary": "DICT_6X6_250"}},
        "legacy": {"board": {"legacy": True}},
    }
    page.goto("/board/")
    said = page.evaluate(WATCH, faults)
    assert said == {name: None if name == "nothing" else name for name in faults}


def test_a_trouble_is_said_with_what_to_do(page: Page) -> None:
    page.goto(capture_page(fault="dark"))
    page.locator("#instruction", has_text="Too dark").wait_for()
    expect(page.locator("#remedy")).to_contain_text("light")
    picture(page, "capture-dark", ["hand"])


def test_a_board_of_the_older_layout_is_recognised_and_taken_as_such(page: Page) -> None:
    boards: list[bool] = []
    page.on(
        "request",
        lambda request: (
            boards.append(json.loads(request.post_data or "")["board"]["legacy"])
            if request.method == "POST" and request.url.endswith("/v1/session")
            else None
        ),
    )
    listen(page)
    page.goto(capture_page(shown_legacy="true"))
    hear(page, "notice", "older layout")
    page.locator("#undo:enabled").wait_for()
    assert boards == [False, True]


def test_a_different_board_can_be_used_or_the_right_one_be_shown(page: Page) -> None:
    listen(page)
    page.goto(capture_page(shown_dictionary="DICT_5X5_100"))
    page.locator("#instruction", has_text="This is a different board").wait_for()
    page.locator("#right-board").click()
    expect(page.locator("#no-board svg path")).to_be_visible()
    picture(page, "capture-different-board", ["hand"])
    page.locator("#use-board").click()
    hear(page, "notice", "This board is used now: 9 × 6")
    page.locator("#undo:enabled").wait_for()
    assert "dictionary=DICT_5X5_50" in address(page), "a reload goes on with it"


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("language", "heading"),
    [("de", "Eine Kamera kalibrieren"), ("uk", "Калібрування камери")],
)
def test_other_languages(page: Page, language: str, heading: str) -> None:
    page.goto(f"/calibrate/?lang={language}")
    page.locator("#welcome-title", has_text=heading).wait_for()
    assert page.evaluate("document.documentElement.lang") == language
    assert page.locator("#language").input_value() == language
    picture(page, f"capture-before-{language}")
    page.locator("#language").select_option("en")
    page.locator("#welcome-title", has_text="Calibrate a camera").wait_for()
    page.goto("/calibrate/")
    expect(page.locator("#welcome-title"), "the choice is kept").to_have_text("Calibrate a camera")
