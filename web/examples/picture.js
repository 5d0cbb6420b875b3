// Picture of a camera for an example to draw over: opened, looked up, rectified.
import { CameraError, open, play } from "../lib/camera.js";
import { DEFAULT_BOARD } from "../lib/board.js";
import { el, part } from "../lib/dom.js";
import { explain } from "../lib/faults.js";
import { t } from "../lib/i18n.js";
import { openPage } from "../lib/page.js";
import { lookup } from "../sdk/calibdb.js";
import { loadSettings } from "../lib/settings.js";
import { setupFrom } from "../lib/virtual/camera.js";
import { trueCalibration } from "../lib/virtual/truth.js";
import words from "../messages/examples.js";

/**
 * @typedef {object} Pinhole the straightened picture's
 * @property {[number, number]} img_size
 * @property {number[][]} camera_matrix
 *
 * @typedef {object} Picture
 * @property {Pinhole} pinhole for a scene over it
 * @property {import("../sdk/calibdb.js").Calibration} calibration of the camera
 * @property {HTMLElement} stage in which it lies, as CSS `object-fit: cover` has it
 * @property {() => [number, number]} viewport size of the stage, px
 */

const WANTED = /** @type {[number, number]} */ ([1280, 720]);

/**
 * Waits for the visitor, then opens the camera; with `?virtual=1` in the address, on pages that offer it, the virtual one at once.
 * @param {(picture: Picture) => void | Promise<void>} draw
 */
export function whenOpen(draw) {
  openPage({ examples: words });
  const parameters = new URLSearchParams(location.search);
  const start = part("start", HTMLButtonElement);
  let opening = false;
  const go = async (/** @type {string} */ id) => {
    if (opening) return;
    opening = true;
    say("");
    try {
      const picture = await begin(id, parameters);
      if (!picture) return;
      part("stage", HTMLElement).hidden = false;
      part("begin", HTMLElement).hidden = true;
      await draw(picture);
    } catch (error) {
      say(error instanceof CameraError ? t(`capture.fault_${error.code}`, { detail: error.detail }) : explain(error));
    } finally {
      opening = false;
    }
  };
  start.addEventListener("click", () => void go(""));
  if (parameters.has("virtual") && document.getElementById("virtually")) void go("virtual");
}

/**
 * @param {string} id of a camera
 * @param {URLSearchParams} parameters
 * @returns {Promise<Picture | null>} null: it is not calibrated yet
 */
async function begin(id, parameters) {
  const camera = await open(id, { parameters, size: WANTED, place: part("virtual", HTMLElement), board: DEFAULT_BOARD });
  /** @type {Picture | null} */
  let picture = null;
  try {
    picture = await shown(camera, parameters);
  } finally {
    if (!picture) camera.close();
  }
  return picture;
}

/**
 * @param {import("../lib/camera.js").OpenCamera} camera @param {URLSearchParams} parameters
 * @returns {Promise<Picture | null>} null: it is not calibrated yet
 */
async function shown({ track, stream, virtual }, parameters) {
  const stage = part("stage", HTMLElement);
  const video = document.createElement("video");
  Object.assign(video, { muted: true, playsInline: true });
  await play(video, stream);

  // This is all that an application needs. Of the virtual camera, which is made of numbers, nobody need be asked.
  const { api, token } = await loadSettings();
  const { calibration, guidanceUrl } = virtual
    ? { calibration: trueCalibration(setupFrom(parameters)), guidanceUrl: null }
    : await lookup(track, { token, api: new URL(api, location.href), exact: true });
  if (!calibration) {
    say(t("examples.unknown"), el("a", { href: guidanceUrl ?? "../../calibrate/" }, t("examples.calibrate")));
    return null;
  }
  const rectifier = await calibration.rectifier({ balance: 0 });

  rectifier.canvas.className = "picture";
  stage.prepend(rectifier.canvas);
  const show = () => {
    if (video.videoWidth === calibration.img_size[0]) rectifier.draw(video);
    video.requestVideoFrameCallback(show);
  };
  video.requestVideoFrameCallback(show);
  const { img_size, camera_matrix } = rectifier;
  return { pinhole: { img_size, camera_matrix }, calibration, stage, viewport: () => [stage.clientWidth, stage.clientHeight] };
}

/** @param {...(string | Node)} what */
function say(...what) {
  const problem = part("problem", HTMLElement);
  problem.replaceChildren(...what.flatMap((each, index) => (index ? [" ", each] : [each])));
  problem.hidden = what.every((each) => each === "");
}
