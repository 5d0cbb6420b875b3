// Picture of a camera for an example to draw over: opened, looked up, rectified.
import { CameraError, open, play } from "../lib/camera.js";
import { DEFAULT_BOARD } from "../lib/board.js";
import { el, part } from "../lib/dom.js";
import { explain } from "../lib/faults.js";
import { number, t } from "../lib/i18n.js";
import { openPage } from "../lib/page.js";
import { lookup, returned } from "../sdk/calibdb.js";
import { loadSettings } from "../lib/settings.js";
import { trueCalibration } from "../lib/virtual/camera.js";
import { setupFrom } from "../lib/virtual/setup.js";
import { poseAt } from "./board.js";

/**
 * @typedef {import("../sdk/calibration.js").Camera} Camera
 *
 * @typedef {object} Pinhole camera without distortion
 * @property {[number, number]} img_size
 * @property {number[][]} camera_matrix
 *
 * @typedef {object} Picture
 * @property {() => Pinhole} pinhole for a scene over the picture as it is shown now
 * @property {Camera} camera the calibration, or the estimate until there is one
 * @property {HTMLElement} stage in which it lies, as CSS `object-fit: cover` has it
 * @property {() => [number, number]} viewport size of the stage, px
 * @property {() => import("../lib/pose.js").Pose} pose of the board in the picture, board → camera
 * @property {(listener: () => void) => void} onChange called now, and when pinhole or viewport are others
 * @property {(listener: () => void) => void} onFrame called with each picture
 */

const WANTED = /** @type {[number, number]} */ ([1280, 720]);
const USUAL_FIELD_DEG = 60; // horizontal field of view assumed for an unknown camera

/**
 * Waits for the visitor, then opens the camera; with `?virtual=1` in the address, on pages that offer it, the virtual
 * one at once.
 * @param {(picture: Picture) => void | Promise<void>} draw
 */
export function whenOpen(draw) {
  openPage();
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
      part("choice", HTMLElement).hidden = false;
      part("begin", HTMLElement).hidden = true;
      await draw(picture);
    } catch (error) {
      const alone = error instanceof CameraError && error.code === "not_found" && !document.getElementById("virtually");
      if (alone) say(t("examples.no_camera"));
      else
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
 * @returns {Promise<Picture | null>} null: nothing is known to draw with
 */
async function begin(id, parameters) {
  const camera = await open(id, {
    parameters,
    size: WANTED,
    place: part("virtual", HTMLElement),
    board: DEFAULT_BOARD,
  });
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
 * @returns {Promise<Picture | null>} null: nothing is known to draw with
 */
async function shown({ track, stream, virtual }, parameters) {
  const stage = part("stage", HTMLElement);
  const video = document.createElement("video");
  Object.assign(video, { muted: true, playsInline: true });
  await play(video, stream);

  const { camera, guidanceUrl } = virtual
    ? { camera: trueCalibration(setupFrom(parameters)), guidanceUrl: null }
    : await cameraOf(track, [video.videoWidth, video.videoHeight]);
  if (guidanceUrl !== null || !camera) {
    const text =
      camera && "interval_90" in camera
        ? t("examples.estimated", { percent: halfWidth(camera) })
        : t("examples.unknown");
    say(text, el("a", { href: guidanceUrl ?? "../../calibrate/" }, t("examples.calibrate")));
  }
  if (!camera) return null;
  const rectifier = await camera.rectifier({ balance: 0 });
  return composed({ stage, video, rectifier, camera, virtual, moves: !parameters.has("still") });
}

/**
 * This is all that an application needs: the calibration that the visitor comes back with, the one that the database
 * has, or the estimate, with the address that leads to a calibration and back.
 * @param {MediaStreamTrack} track @param {[number, number]} size
 * @returns {Promise<{camera: Camera | import("../sdk/calibdb.js").Estimate | null, guidanceUrl: string | null}>}
 */
async function cameraOf(track, size) {
  const { api, token } = await loadSettings();
  const manner = { token, api: new URL(api, location.href) };
  const fresh = await returned(manner);
  if (fresh?.img_size.join() === size.join()) return { camera: fresh, guidanceUrl: null };
  const { camera, guidanceUrl } = await lookup(track, { ...manner, exact: true, accept: "estimate" });
  if (guidanceUrl === null) return { camera, guidanceUrl };
  const there = new URL(guidanceUrl, location.href);
  there.searchParams.set("return_to", location.href.split("#")[0]);
  return { camera, guidanceUrl: there.href };
}

/**
 * Half the width of an estimate's interval, percent of its field of view.
 * @param {import("../sdk/calibration.js").EstimateData} estimate
 */
const halfWidth = ({
  hfov_deg,
  interval_90: {
    hfov_deg: [low, high],
  },
}) => number((50 * (high - low)) / hfov_deg, 0);

/**
 * Puts the picture on the stage, straightened with the calibration or as it is without.
 * @param {{stage: HTMLElement, video: HTMLVideoElement, rectifier: import("../sdk/rectifier.js").Rectifier, moves:
 *   boolean, camera: Camera, virtual: import("../lib/virtual/camera.js").VirtualCamera | null}} parts
 * @returns {Picture}
 */
function composed({ stage, video, rectifier, camera, virtual, moves }) {
  const source = virtual?.canvas ?? video;
  const choice = part("calibrated", HTMLInputElement);
  /** @type {(() => void)[]} */
  const changed = [];
  /** @type {(() => void)[]} */
  const drawn = [];
  const change = () => {
    const shown = choice.checked ? rectifier.canvas : source;
    shown.classList.add("picture");
    shown.classList.remove("virtual-camera");
    stage.querySelector(":scope > .picture")?.remove();
    stage.prepend(shown);
    for (const listener of changed) listener();
  };
  choice.addEventListener("change", change);
  new ResizeObserver(change).observe(stage);
  const swings = virtual && moves && !matchMedia("(prefers-reduced-motion: reduce)").matches;
  const start = performance.now();
  const frame = () => {
    if (swings) virtual.hold(poseAt(camera, (performance.now() - start) / 1000));
    if (choice.checked && (virtual || video.videoWidth === camera.img_size[0])) rectifier.draw(source);
    for (const listener of drawn) listener();
    requestAnimationFrame(frame);
  };
  change();
  requestAnimationFrame(frame);
  return {
    pinhole: () => (choice.checked ? rectifier : usualPinhole(camera.img_size)),
    camera,
    stage,
    viewport: () => [stage.clientWidth, stage.clientHeight],
    pose: () => virtual?.shown ?? poseAt(camera, 0),
    onChange: (listener) => {
      changed.push(listener);
      listener();
    },
    onFrame: (listener) => void drawn.push(listener),
  };
}

/**
 * Pinhole that applications assume of a camera they know nothing about.
 * @param {readonly [number, number]} size
 * @returns {Pinhole}
 */
function usualPinhole([width, height]) {
  const focal = width / 2 / Math.tan((USUAL_FIELD_DEG * Math.PI) / 360);
  return {
    img_size: [width, height],
    camera_matrix: [
      [focal, 0, (width - 1) / 2],
      [0, focal, (height - 1) / 2],
      [0, 0, 1],
    ],
  };
}

/** @param {...(string | Node)} what */
function say(...what) {
  const problem = part("problem", HTMLElement);
  problem.replaceChildren(...what.flatMap((each, index) => (index ? [" ", each] : [each])));
  problem.hidden = what.every((each) => each === "");
}
