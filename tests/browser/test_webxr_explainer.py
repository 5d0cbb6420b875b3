"""The samples of docs/webxr.md."""

import re
from collections.abc import Iterator
from pathlib import Path
from textwrap import dedent
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Page

from tests.helpers.browser.elsewhere import serving
from tests.helpers.browser.scripts import PLAIN
from tests.helpers.browser.specimens import rig_result
from tests.helpers.browser.webxr import LABEL, SHARED, attributes, known_camera, script
from tests.helpers.vectors import recorded

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
def known(page: Page) -> dict[str, Any]:
    page.add_init_script(CAMERA)
    return known_camera(page)


@pytest.fixture
def elsewhere(tmp_path: Path, stack: str) -> Iterator[str]:
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
    assert seen["first"] == attributes(known)
    assert seen["known"] is True
    assert seen["size"] == [1280, 720]
    assert 0 < seen["focal"] < 2 * known["camera_matrix"][0][0] / 1280


def test_none_is_left_out() -> None:
    named = re.findall(r'sample\((".*?"|\'.*?\')\)', Path(__file__).read_text())
    run = {sample(name[1:-1]) for name in named}
    assert len(run) == len(SAMPLES) == 9


@pytest.mark.thorough
def test_two_cameras_of_a_rig_are_two_eyes(page: Page, stack: str) -> None:
    pair = recorded("pairs")[0]
    result = rig_result() | {"unit": "squares"}
    page.route("**/v1/rigs/*/result", lambda route: route.fulfill(json=result))
    page.goto(PLAIN)
    body = f"""
      const [leftVideo, rightVideo] = [(await webcam([640, 480])).video, (await webcam([640, 480])).video];
      {sample("useRig")}
      const session = await navigator.xr.requestSession("immersive-ar");
      await layered(session, 800, 300);
      const space = await session.requestReferenceSpace("local");
      const shown = () => document.querySelectorAll("div > div > canvas").length;
      const found = await new Promise((done) => {{
        const next = (now, frame) => {{
          const {{ views }} = frame.getViewerPose(space);
          const layer = session.renderState.baseLayer;
          if (!views[1].distortionModel) return session.requestAnimationFrame(next);
          const seen = views.map((view) => ({{
            ...look(view),
            eye: view.eye,
            p: [...view.projectionMatrix],
            m: [...view.transform.matrix],
            viewport: [layer.getViewport(view)].map((each) => [each.x, each.width])[0],
          }}));
          done({{ seen, shown: shown(), stage: [innerWidth, innerHeight] }});
        }};
        session.requestAnimationFrame(next);
      }});
      await session.end();
      return {{ ...found, left: shown() }};
    """
    found = page.evaluate(script(body.replace(SERVICE, stack)))
    left, right = found["seen"]
    assert [left["eye"], right["eye"]] == ["left", "right"]
    for view, side in ((left, "left"), (right, "right")):
        assert view["matrix"][0] == np.float32(pair[side]["camera_matrix"][0][0])
    assert [left["viewport"], right["viewport"]] == [[0, 400], [400, 400]]
    assert (found["shown"], found["left"]) == (2, 0)
    # Both look along the same axis, and the right one is one baseline to the right, in metres.
    one, other = (np.reshape(view["m"], (4, 4)).T for view in (left, right))
    assert np.abs(one[:3, :3] - other[:3, :3]).max() < 1e-6
    step = one[:3, :3].T @ (other[:3, 3] - one[:3, 3])
    assert step == pytest.approx([0.03 * np.linalg.norm(pair["pose"]["tvec"]), 0, 0], abs=1e-6)
    # The picture covers its half of the window, so its focal length is scaled by the larger ratio.
    width, height = found["stage"]
    scale = max(width / 2 / 640, height / 480)
    assert left["p"][0] == pytest.approx(2 * pair["P1"][0][0] * scale / (width / 2), rel=1e-6)


def test_straightened_picture_own_provider_and_raw_camera_access(
    page: Page, known: dict[str, Any], stack: str
) -> None:
    page.goto(PLAIN)
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

    page.goto(PLAIN)  # with the browser's own sessions
    fisheye = known | {"distortion_model": "fisheye", "distortion_coefficients": [-0.125, 0.5, 0, 0.25]}
    page.route("**/my-cameras/rectilinear.json", lambda route: route.fulfill(json=known))
    page.route("**/my-cameras/fisheye.json", lambda route: route.fulfill(json=fisheye))
    body = f"""
      {sample("/my-cameras/")}
      const session = await navigator.xr.requestSession("inline");
      await layered(session);
      const space = await session.requestReferenceSpace("viewer");
      const seen = await until(session, space, (view) => view.distortionModel);
      const view = {{ projectionMatrix: seen.p, camera: {{ width: 640, height: 360 }} }};
      {sample("view.camera.width")}
      session.updateRenderState({{ distortionModel: "fisheye" }});
      const {{ coefficients }} = await until(session, space, (view) => view.distortionModel === "fisheye");
      void session.end();
      return {{ seen, matrix, coefficients, native: /native code/.test(XRSession.toString()) }};
    """
    found = page.evaluate(script(body.replace(SERVICE, stack)))
    assert (found["native"], found["coefficients"]) == (True, fisheye["distortion_coefficients"])
    assert found["seen"]["matrix"][0] == np.float32(known["camera_matrix"][0][0])
    # A quarter of a turn from top to bottom, as inline sessions begin.
    assert found["matrix"] == pytest.approx([180, 0, 0, 0, 180, 0, 319.5, 179.5, 1], abs=1e-4)
