"""The samples of docs/webxr.md, run as they stand there."""

import re
from collections.abc import Iterator
from pathlib import Path
from textwrap import dedent
from typing import Any

import httpx
import numpy as np
import pytest
from playwright.sync_api import Page

from tests.helpers.browser.elsewhere import serving
from tests.helpers.browser.webxr import LABEL, SHARED, calibrated, script

from .conftest import ROOT

TEXT = (ROOT / "docs/webxr.md").read_text()
PAGE, *_ = re.findall(r"^```html\n(.*?)^```", TEXT, re.DOTALL | re.MULTILINE)
SAMPLES = [dedent(each) for each in re.findall(r"^ *```js\n(.*?)^ *```", TEXT, re.DOTALL | re.MULTILINE)]
SERVICE = "https://calibdb.example"
CAMERA = f"""{{ {SHARED}
  navigator.mediaDevices.getUserMedia = async () => (await webcam([1280, 720], "{LABEL}")).video.srcObject;
}}"""
WAIT = "const wait = async (holds) => { while (!holds()) await new Promise(requestAnimationFrame); };"


def sample(containing: str) -> str:
    """The one that has some words, its imports as a function may have them."""
    (found,) = [each for each in SAMPLES if containing in each]
    return re.sub(r'import (\{.*?\}) from "(.*?)";', r'const \1 = await import("\2");', found)


@pytest.fixture
def known(page: Page, api: httpx.Client) -> dict[str, Any]:
    """Give the calibration of the camera that the page opens."""
    page.add_init_script(CAMERA)
    return calibrated(api)


@pytest.fixture
def elsewhere(tmp_path: Path, stack: str) -> Iterator[str]:
    """Address of a page of another origin, which is the explainer's."""
    page = PAGE.replace(SERVICE, stack).replace("<video", '<link rel="icon" href="data:,"><video')
    (tmp_path / "index.html").write_text(page)
    with serving(tmp_path) as address:
        yield address


def test_three_lines_of_a_page(page: Page, known: dict[str, Any], elsewhere: str, stack: str) -> None:
    page.goto(elsewhere)
    page.wait_for_function("'cameraMatrix' in XRView.prototype")
    body = f"""{WAIT}
      const tracked = [];
      const track = (...of) => tracked.push(of);
      {sample("requestSession")}
      {sample("onFrame")}
      await wait(() => tracked.length > 0);
      const [first] = tracked;
      {sample('"fisheye"')}
      await wait(() => tracked.at(-1)[2] === "fisheye");
      {sample("in XRView.prototype")}
      await session.end();
      const {{ lookup }} = await import("{stack}/sdk/calibdb.js");
      const [track2] = document.querySelector("video").srcObject.getVideoTracks();
      const {{ calibration }} = await lookup(track2, {{ token: "cdb_dev_local" }});
      const scene = document.createElement("canvas");
      {sample("distorter")}
      const size = [distorter.canvas.width, distorter.canvas.height];
      return {{ first: [[...first[0]], [...first[1]], first[2]], known, size, focal: projection[0] }};
    """
    seen = page.evaluate(f"async () => {{ {body} }}")
    matrix = np.array(known["camera_matrix"]).T.ravel().astype(np.float32).tolist()
    coefficients = np.array(known["distortion_coefficients"]).astype(np.float32).tolist()
    assert seen["first"] == [matrix, coefficients, "rectilinear"]
    assert seen["known"] is True
    assert seen["size"] == [1280, 720]
    assert 0 < seen["focal"] < 2 * matrix[0] / 1280, "wider than the picture"


def test_none_is_left_out() -> None:
    named = re.findall(r'sample\((".*?"|\'.*?\')\)', Path(__file__).read_text())
    run = {sample(name[1:-1]) for name in named}
    assert len(run) == len(SAMPLES) == 8


def test_the_picture_straightened(page: Page, known: dict[str, Any]) -> None:
    page.goto("/board/")
    body = f"""{WAIT}
      const {{ useCamera }} = await import("/webxr/camera.js");
      const video = document.createElement("video");
      document.body.append(video);
      video.srcObject = await navigator.mediaDevices.getUserMedia({{ video: true }});
      await useCamera(video, {{ token: "cdb_dev_local" }});
      {sample("rectify: true")}
      const session = await navigator.xr.requestSession("immersive-ar");
      const canvas = await layered(session);
      await session.requestReferenceSpace("local");
      await wait(() => video.nextElementSibling?.tagName === "CANVAS" && video.nextElementSibling !== canvas);
      const {{ width, height }} = video.nextElementSibling;
      await session.end();
      return [width, height];
    """
    assert page.evaluate(script(body)) == known["img_size"]


def test_a_provider_of_its_own_and_raw_camera_access(page: Page, known: dict[str, Any], stack: str) -> None:
    page.route("**/my-cameras/rectilinear.json", lambda route: route.fulfill(json=known))
    page.goto("/board/")
    body = f"""
      {sample("/my-cameras/")}
      const session = await navigator.xr.requestSession("inline");
      await layered(session);
      const space = await session.requestReferenceSpace("viewer");
      const seen = await until(session, space, (view) => view.distortionModel);
      const view = {{ projectionMatrix: seen.p, camera: {{ width: 640, height: 360 }} }};
      {sample("view.camera.width")}
      void session.end();
      return {{ seen, matrix }};
    """
    found = page.evaluate(script(body.replace(SERVICE, stack)))
    assert found["seen"]["matrix"][0] == np.float32(known["camera_matrix"][0][0])
    # A quarter of a turn from top to bottom, as inline sessions begin.
    assert found["matrix"] == pytest.approx([180, 0, 0, 0, 180, 0, 319.5, 179.5, 1], abs=1e-4)
