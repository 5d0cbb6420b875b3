"""Loss of the WebGL context."""

import json
from typing import Any

import pytest
from playwright.sync_api import BrowserContext

from tests.helpers.browser.firefox import InFirefox
from tests.helpers.browser.scripts import PLAIN

from .test_rectifier import HALF, calibration

ADDRESS = "/ar/?virtual=1&k1=-0.3&error=0&rate=10&hand=quick"
#: a context taken away, and given back; what is drawn meanwhile is nothing
GONE_AND_BACK = """
  const gone = async (canvas) => {
    const extension = canvas.getContext("webgl2").getExtension("WEBGL_lose_context");
    const lost = new Promise((done) => canvas.addEventListener("webglcontextlost", done, { once: true }));
    extension.loseContext();
    await lost;
    await new Promise((done) => setTimeout(done)); // whether it may come back is decided once all have heard
    return () => new Promise((done) => {
      canvas.addEventListener("webglcontextrestored", done, { once: true });
      extension.restoreContext();
    });
  };
"""
#: the sum of what a Rectifier and a Distorter draw, before, while and after the GPU was lost
DRAWN = f"""async (calibration) => {{
  {GONE_AND_BACK}
  const {{ Calibration }} = await import("/sdk/calibdb.js");
  const sum = (canvas) => {{
    const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
    copy.drawImage(canvas, 0, 0);
    return copy.getImageData(0, 0, canvas.width, canvas.height).data.reduce((all, value) => all + value, 0);
  }};
  const sums = [];
  for (const kind of ["rectifier", "distorter"]) {{
    const warp = await new Calibration(calibration)[kind]();
    const picture = new OffscreenCanvas(...(kind === "rectifier" ? calibration.img_size : warp.img_size));
    const paint = picture.getContext("2d");
    for (let x = 0; x < picture.width; x += 40) {{
      paint.fillStyle = `hsl(${{x}} 80% 50%)`;
      paint.fillRect(x, 0, 40, picture.height);
    }}
    const seen = () => {{
      warp.draw(picture);
      return sum(warp.canvas);
    }};
    const before = seen();
    const back = await gone(warp.canvas);
    const meanwhile = seen();
    await back();
    sums.push({{ before, meanwhile, after: seen() }});
    warp.dispose();
  }}
  return sums;
}}"""
#: how many pixels of the drawing are seen, in the task in which they were drawn
LAYER = """
  const layer = () => document.getElementById("layers").lastChild;
  const seen = () => new Promise((done) => {
    const stage = document.getElementById("stage");
    const observer = new MutationObserver(() => {
      observer.disconnect();
      const { width, height } = layer();
      const copy = new OffscreenCanvas(width, height).getContext("2d");
      copy.drawImage(layer(), 0, 0);
      const { data } = copy.getImageData(0, 0, width, height);
      done(data.filter((value, at) => at % 4 === 3 && value > 0).length);
    });
    observer.observe(stage, { attributes: true, attributeFilter: ["data-shown"] });
  });
"""
ON_THE_PAGE = f"""async () => {{
  {GONE_AND_BACK}
  {LAYER}
  const counts = [];
  for (const button of document.querySelectorAll("#modes button")) {{
    button.click();
    const before = await seen();
    const back = await gone(layer());
    await back();
    let after = await seen();
    for (let frame = 0; frame < 20 && after === 0; frame++) after = await seen();
    counts.push({{ mode: button.value, before, after }});
  }}
  return counts;
}}"""
FOR_EVER = f"async () => {{ {GONE_AND_BACK} {LAYER} await gone(layer()); }}"


def check_drawn(sums: list[dict[str, Any]]) -> None:
    assert len(sums) == 2
    for each in sums:
        assert each["before"] > 1e6
        assert each["after"] == each["before"]
        assert each["meanwhile"] < each["before"]


def test_what_was_on_the_gpu_is_made_anew(context: BrowserContext) -> None:
    page = context.new_page()
    page.goto(PLAIN)
    check_drawn(page.evaluate(DRAWN, calibration("rectilinear", HALF)))


@pytest.mark.thorough
def test_what_was_on_the_gpu_is_made_anew_in_firefox(stack: str, in_firefox: InFirefox) -> None:
    check_drawn(in_firefox(f"{stack}{PLAIN}", f"() => ({DRAWN})({json.dumps(calibration('rectilinear'))})"))


@pytest.mark.thorough
def test_overlays_return_with_the_gpu_and_report_its_loss(context: BrowserContext) -> None:
    overlays = context.new_page()
    overlays.goto(ADDRESS)
    overlays.locator("#rms:not(:empty)").wait_for()
    counts = overlays.evaluate(ON_THE_PAGE)
    assert [each["mode"] for each in counts] == ["matrix", "rectified", "distorted", "estimate"]
    for each in counts:
        assert each["before"] > 10_000, each
        assert each["after"] > 0.9 * each["before"], each
    overlays.evaluate(FOR_EVER)
    overlays.locator("#failure", has_text="The graphics processor stopped responding.").wait_for()
    overlays.locator("#again").click()
    overlays.locator("#rms:not(:empty)").wait_for()
