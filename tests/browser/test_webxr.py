"""WebXR that knows its camera: the browser's own, and on a webcam where that cannot augment reality."""

from typing import Any

import httpx
import numpy as np
import pytest
from playwright.sync_api import BrowserContext, Page

from tests.helpers.browser.firefox import InFirefox
from tests.helpers.browser.webxr import LABEL, TRUTH, calibrated, script

NATIVE = """
  const { extend } = await import("/webxr/extension.js");
  const { lookup } = await import("/sdk/calibdb.js");
  const token = "cdb_dev_local";
  const run = async (track) => {
    let look;
    const seen = new Promise((done) => look = done); // a quick service might answer before the first frame
    const answered = new Promise((done) => {
      extend(async (session, model) => {
        await seen;
        const { calibration } = await lookup(track, { token, model });
        done();
        return calibration;
      });
    });
    const session = await navigator.xr.requestSession("inline");
    await layered(session);
    const space = await session.requestReferenceSpace("viewer");
    const none = await until(session, space, () => true);
    look();
    await answered;
    return { session, space, none };
  };
  const stranger = await run((await webcam([1280, 720])).track);
  const strange = await until(stranger.session, stranger.space, () => true);
  stranger.session.updateRenderState({ distortionModel: "fisheye" });
  const still = await until(stranger.session, stranger.space, () => true);
  void stranger.session.end(); // which a browser without a screen does not confirm
  const { session, space, none } = await run((await webcam([1280, 720], label)).track);
  const first = await until(session, space, (view) => view.distortionModel === "rectilinear");
  let refused = null;
  try {
    session.updateRenderState({ distortionModel: "brown" });
  } catch (error) {
    refused = error.name;
  }
  session.updateRenderState({ distortionModel: "fisheye" });
  const second = await until(session, space, (view) => view.distortionModel === "fisheye");
  void session.end();
  const native = /native code/.test(XRSession.toString());
  return { native, nothing: [stranger.none, strange, still, none], first, second, refused };
"""
RAW = """
  // As Chrome on Android has it, where raw camera access was granted; the projection is the browser's own.
  Object.defineProperty(XRView.prototype, "camera", { value: { width: 640, height: 360 } });
  const { extend } = await import("/webxr/extension.js");
  const asked = [];
  extend(async (session, model, size) => void asked.push(size));
  const session = await navigator.xr.requestSession("inline");
  await layered(session);
  session.updateRenderState({ inlineVerticalFieldOfView: 1.25 });
  const space = await session.requestReferenceSpace("viewer");
  const view = await until(session, space, () => true);
  void session.end();
  return { view, asked };
"""
CHANGING = """
  const { useCamera } = await import("/webxr/camera.js");
  const { video, track, resize } = await webcam([1280, 720], label);
  const answers = [];
  const onAnswer = ({ calibration, reason }) => answers.push(reason ?? calibration.img_size);
  const stop = await useCamera(video, { token: "cdb_dev_local", onAnswer });
  const session = await navigator.xr.requestSession("immersive-ar", { optionalFeatures: ["local-floor"] });
  await layered(session);
  const space = await session.requestReferenceSpace("local-floor");
  const seen = [await until(session, space, (view) => view.distortionModel)];
  for (const [size, known] of [[[720, 1280], false], [[1280, 720], true]]) {
    resize(...size);
    track.dispatchEvent(new Event("configurationchange"));
    seen.push(await until(session, space, (view) => (view.distortionModel !== null) === known));
    while (answers.length < seen.length) await new Promise(requestAnimationFrame);
  }
  stop();
  await session.end();
  return { seen, answers };
"""
#: what views say from the frame on in which the video shows another picture, while nobody answers
TURNED = """
  const { useCamera } = await import("/webxr/camera.js");
  const { video, resize } = await webcam([1280, 720], label);
  let silent = false;
  const slowly = (...request) => (silent ? new Promise(() => {}) : fetch(...request));
  const stop = await useCamera(video, { token: "cdb_dev_local", cache: null, fetch: slowly });
  const session = await navigator.xr.requestSession("immersive-ar");
  await layered(session);
  const space = await session.requestReferenceSpace("local");
  const before = await until(session, space, (view) => view.distortionModel);
  silent = true;
  resize(720, 1280);
  const after = await until(session, space, () => video.videoWidth === 720);
  stop();
  await session.end();
  return { before, after };
"""
IMMERSIVE = """
  const { extend } = await import("/webxr/extension.js");
  const { install, isNeeded } = await import("/webxr/install.js");
  const needed = await isNeeded();
  const { video } = await webcam();
  let calibration = null;
  install({ video, pinhole: () => calibration });
  const again = extend(async (_, model) => calibration && known[model]);
  const supported = await navigator.xr.isSessionSupported("immersive-ar");
  const session = await navigator.xr.requestSession("immersive-ar");
  const twice = await navigator.xr.requestSession("immersive-ar").catch(({ name }) => name);
  const canvas = await layered(session);
  const space = await session.requestReferenceSpace("local");
  const none = await until(session, space, () => true);
  calibration = known.rectilinear;
  await again();
  const first = await until(session, space, (view) => view.distortionModel === "rectilinear");
  session.updateRenderState({ distortionModel: "fisheye" });
  const second = await until(session, space, (view) => view.distortionModel === "fisheye");
  const over = canvas.parentNode === video.parentNode && canvas.parentNode !== document.body;
  const { width, height } = canvas.getBoundingClientRect();
  const ended = new Promise((done) => session.addEventListener("end", done));
  window.dispatchEvent(new KeyboardEvent("keydown", { key: "Escape" }));
  await ended;
  const back = video.parentNode === document.body && !canvas.getAttribute("style");
  return { needed, supported, twice, none, first, second, over, back, window: [width, height] };
"""
#: matrix and distortion of `known` in webxr.js
MATRIX = [500, 0, 0, 0, 505, 0, 325, 178, 1]
COEFFICIENTS = [-0.25, 0.0625, 0, 0, 0]


def check_nothing(said: dict[str, Any]) -> None:
    assert (said["matrix"], said["coefficients"], said["model"]) == (None, None, None)


def check_answered(said: dict[str, Any], answer: dict[str, Any]) -> None:
    """A view says what the service does, in single precision and column by column."""
    matrix = np.array(answer["camera_matrix"]).T.ravel().astype(np.float32)
    coefficients = np.array(answer["distortion_coefficients"]).astype(np.float32)
    assert (said["matrix"], said["coefficients"]) == (matrix.tolist(), coefficients.tolist())
    assert said["model"] == answer["distortion_model"]


def projection(window: list[float]) -> list[float]:
    """P0, P5, P8, P9 of the calibration `known`, its picture laid over all of a window."""
    w, h = window
    scale = max(w / 640, h / 360)
    return [
        2 * scale * 500 / w,
        2 * scale * 505 / h,
        -(2 * scale * (325 + 0.5 - 320)) / w,
        (2 * scale * (178 + 0.5 - 180)) / h,
    ]


def check_immersive(seen: dict[str, Any]) -> None:
    assert seen["needed"] is True
    assert seen["supported"] is True
    assert seen["twice"] == "InvalidStateError"
    check_nothing(seen["none"])
    assert seen["none"]["views"] == 1
    first, second = seen["first"], seen["second"]
    assert (first["matrix"], first["coefficients"]) == (MATRIX, COEFFICIENTS)
    assert second["matrix"] == [490, 0, 0, 0, 495, 0, 324, 177, 1]
    assert (second["coefficients"], second["model"]) == ([-0.125, 0.5, 0, 0.25], "fisheye")
    assert seen["window"] == [1440, 900]
    p = first["p"]
    assert [p[0], p[5], p[8], p[9]] == pytest.approx(projection(seen["window"]), abs=1e-6)
    assert (seen["over"], seen["back"]) == (True, True)


def test_the_browsers_own_inline_session(context: BrowserContext, api: httpx.Client) -> None:
    calibrated(api)
    page = context.new_page()  # which may complain: an unknown camera is a 404
    page.goto("/board/")
    seen = page.evaluate(script(NATIVE, label=LABEL))
    assert seen["native"] is True
    for nothing in seen["nothing"]:
        check_nothing(nothing)
        assert nothing["views"] == 1, "and frames come"
    assert seen["refused"] == "TypeError"
    check_answered(seen["first"], calibrated(api))
    check_answered(seen["second"], calibrated(api, "fisheye"))
    assert abs(seen["first"]["matrix"][0] / TRUTH.fx - 1) < 0.005
    assert seen["first"]["coefficients"][0] == pytest.approx(TRUTH.k1, abs=0.02)


def test_augmented_reality_on_a_webcam(page: Page) -> None:
    page.set_viewport_size({"width": 1440, "height": 900})
    page.goto("/board/")
    check_immersive(page.evaluate(script(IMMERSIVE)))


def test_augmented_reality_on_a_webcam_in_firefox(stack: str, in_firefox: InFirefox) -> None:
    check_immersive(in_firefox(f"{stack}/board/", script(IMMERSIVE)))


def test_raw_camera_access_gives_what_the_browser_knows(page: Page) -> None:
    page.goto("/board/")
    seen = page.evaluate(script(RAW))
    focal = 180 / np.tan(1.25 / 2)
    assert seen["view"]["matrix"] == pytest.approx([focal, 0, 0, 0, focal, 0, 319.5, 179.5, 1], abs=1e-4)
    assert (seen["view"]["coefficients"], seen["view"]["model"]) == (None, None)
    assert seen["asked"] == [[640, 360]]


def test_a_camera_that_is_turned_is_asked_for_again(context: BrowserContext, api: httpx.Client) -> None:
    known = calibrated(api)
    page = context.new_page()  # which may complain: what is unknown upright is a 404
    page.goto("/board/")
    found = page.evaluate(script(CHANGING, label=LABEL))
    first, turned, again = found["seen"]
    check_answered(first, known)
    check_nothing(turned)
    check_answered(again, known)
    assert [each if isinstance(each, str) else tuple(each) for each in found["answers"]] == [
        (1280, 720),
        "other_size",
        (1280, 720),
    ]


def test_a_picture_that_is_turned_never_has_the_former_ones_matrix(page: Page, api: httpx.Client) -> None:
    known = calibrated(api)
    page.goto("/board/")
    seen = page.evaluate(script(TURNED, label=LABEL))
    check_answered(seen["before"], known)
    check_nothing(seen["after"])
