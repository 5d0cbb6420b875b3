"""The viewfinder at common window sizes: all controls are in reach, and nothing moves while one aims."""

from playwright.sync_api import Page

from ...conftest import THOROUGH
from .scripts import page_function

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
SIZES = [(320, 480), (390, 844), (480, 320), (844, 390), (820, 1180), (1440, 900)]
if THOROUGH:
    SIZES += [
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
    for width, height in SIZES:
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
