"""WebXR that knows its camera, on a webcam where the browser has nothing for augmented reality."""

from typing import Any

import pytest
from playwright.sync_api import Page

#: calibrations of one camera under two models, as a lookup would give them
KNOWN = """const known = {
  rectilinear: { img_size: [640, 360], camera_matrix: [[500, 0, 325], [0, 505, 178], [0, 0, 1]],
    distortion_model: "rectilinear", distortion_coefficients: [-0.25, 0.0625, 0, 0, 0] },
  fisheye: { img_size: [640, 360], camera_matrix: [[490, 0, 324], [0, 495, 177], [0, 0, 1]],
    distortion_model: "fisheye", distortion_coefficients: [-0.125, 0.5, 0, 0.25] },
};"""
#: what a session's frames say of their views, until a condition holds
WATCHING = """
const look = (view) => ({
  matrix: view.cameraMatrix && [...view.cameraMatrix], model: view.distortionModel,
  coefficients: view.distortionCoefficients && [...view.distortionCoefficients],
});
const until = (session, space, holds) => new Promise((resolve, reject) => {
  let frames = 0;
  const next = (now, frame) => {
    const views = frame.getViewerPose(space)?.views ?? [];
    const [view] = views;
    if (view && holds(view)) resolve({ ...look(view), views: views.length, p: [...view.projectionMatrix] });
    else if (++frames > 300) reject(new Error("no such frame: " + JSON.stringify(views.map(look))));
    else session.requestAnimationFrame(next);
  };
  session.requestAnimationFrame(next);
});
const layered = async (session) => {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [640, 360];
  document.body.append(canvas);
  const gl = canvas.getContext("webgl2");
  session.updateRenderState({ baseLayer: new XRWebGLLayer(session, gl) });
  return canvas;
};
const webcam = async () => {
  const source = document.createElement("canvas");
  [source.width, source.height] = [640, 360];
  const context = source.getContext("2d");
  document.body.append(source);
  setInterval(() => context.fillRect(0, 0, 640, 360), 50);
  const video = document.createElement("video");
  video.muted = true;
  video.srcObject = source.captureStream(30);
  document.body.append(video);
  await video.play();
  return video;
};"""
IMMERSIVE = f"""async () => {{ {KNOWN} {WATCHING}
  const {{ extend }} = await import("/webxr/extension.js");
  const {{ install, isNeeded }} = await import("/webxr/install.js");
  const needed = await isNeeded();
  const video = await webcam();
  let calibration = null;
  install({{ video, pinhole: () => calibration }});
  const again = extend(async (_, model) => calibration && known[model]);
  const supported = await navigator.xr.isSessionSupported("immersive-ar");
  const session = await navigator.xr.requestSession("immersive-ar");
  const canvas = await layered(session);
  const space = await session.requestReferenceSpace("local");
  const none = await until(session, space, () => true);
  calibration = known.rectilinear;
  await again(session);
  const first = await until(session, space, (view) => view.distortionModel === "rectilinear");
  session.updateRenderState({{ distortionModel: "fisheye" }});
  const second = await until(session, space, (view) => view.distortionModel === "fisheye");
  const over = canvas.parentNode === video.parentNode && canvas.parentNode !== document.body;
  const ended = new Promise((done) => session.addEventListener("end", done));
  await session.end();
  await ended;
  return {{ needed, supported, none, first, second, over, back: video.parentNode === document.body }};
}}"""
MATRIX = [500, 0, 0, 0, 505, 0, 325, 178, 1]
COEFFICIENTS = [-0.25, 0.0625, 0, 0, 0]
PROJECTION = [2 * 500 / 640, 2 * 505 / 360, 1 - 2 * 325.5 / 640, 2 * 178.5 / 360 - 1]


def check_known(said: dict[str, Any]) -> None:
    assert (said["matrix"], said["coefficients"], said["model"]) == (MATRIX, COEFFICIENTS, "rectilinear")


def check_fisheye(said: dict[str, Any]) -> None:
    assert said["matrix"] == [490, 0, 0, 0, 495, 0, 324, 177, 1]
    assert (said["coefficients"], said["model"]) == ([-0.125, 0.5, 0, 0.25], "fisheye")


def check_immersive(seen: dict[str, Any]) -> None:
    assert seen["needed"] is True
    assert seen["supported"] is True
    none = seen["none"]
    assert (none["matrix"], none["coefficients"], none["model"]) == (None, None, None), "and frames come"
    assert none["views"] == 1
    check_known(seen["first"])
    check_fisheye(seen["second"])
    p = seen["first"]["p"]
    assert [p[0], p[5], p[8], p[9]] == pytest.approx(PROJECTION, abs=1e-6)
    assert (seen["over"], seen["back"]) == (True, True)


def test_augmented_reality_on_a_webcam(page: Page) -> None:
    page.goto("/board/")
    check_immersive(page.evaluate(IMMERSIVE))
