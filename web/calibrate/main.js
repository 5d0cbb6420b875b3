// The capture page: effects around the reducer. Events go in, `decide` says what to do, `render` shows it.
import { DEFAULT_BOARD } from "../board/geometry.js";
import { cameraKey } from "../sdk/calibdb.js";
import { loadSettings } from "../settings.js";
import { Api, ApiError, OfflineError } from "./api.js";
import { CameraError, cameras, facts, lockFocus, open } from "./camera.js";
import { Detector, DetectorError, grab } from "./detector.js";
import { findParts, render } from "./render.js";
import { CaptureSession } from "./session.js";
import { decide, initial, isOfSize, reduce } from "./state.js";
import { motion } from "./stillness.js";

/**
 * @typedef {import("./state.js").State} State
 * @typedef {import("./state.js").Event} Event
 */

const STEADY = 3; // px between the hold's last frame and the one that is sent, at 1280 px width
const FOCUSED = 0.6; // part of the board's corners from which the lens is taken to be focused on it

const parameters = new URLSearchParams(location.search);
const parts = findParts();

/** @type {State} */
let state = initial(boardFrom(parameters), wantedFrom(parameters));
/** @type {State | null} */
let shown = null;
/** One run of the capture; a new one makes all that is still on its way for the old one meaningless. */
/** @type {AbortController | null} */
let run = null;
/** @type {Promise<Detector> | null} */
let detector = null;

/** @param {Event} event */
function dispatch(event) {
  state = reduce(state, event);
  render(parts, state, shown);
  if (shown?.picture && shown.picture !== state.picture) URL.revokeObjectURL(shown.picture);
  shown = state;
}

/** @param {URLSearchParams} query @returns {State["wanted"]} */
function wantedFrom(query) {
  const [, width, height] = /^(\d{1,5})[x×,](\d{1,5})$/.exec(query.get("img_size") ?? "") ?? [];
  return {
    camera: query.get("camera"),
    img_size: width ? [Number(width), Number(height)] : null,
    distortion_model: query.get("distortion_model") === "fisheye" ? "fisheye" : "rectilinear",
  };
}

/** @param {URLSearchParams} query @returns {State["board"]} */
function boardFrom(query) {
  const [, columns, rows] = /^(\d{1,2})x(\d{1,2})$/.exec(query.get("squares") ?? "") ?? [];
  return columns ? { ...DEFAULT_BOARD, squares: [Number(columns), Number(rows)] } : DEFAULT_BOARD;
}

/** OpenCV is loaded once; a detector that failed is made anew. @returns {Promise<Detector>} */
function openDetector() {
  detector ??= Detector.open(state.board, (fraction) => dispatch({ type: "loading", fraction })).catch((error) => {
    detector = null;
    throw error;
  });
  return detector;
}

/** @param {string} choice id of a camera */
async function capture(choice) {
  run?.abort();
  const own = run = new AbortController();
  const { signal } = own;
  dispatch({ type: "open" });
  try {
    const camera = await open(choice, {
      parameters, board: state.board, place: document.body, size: state.wanted.img_size ?? [1280, 720],
    });
    signal.addEventListener("abort", () => camera.close());
    if (signal.aborted) return camera.close();
    parts.video.srcObject = camera.stream;
    await parts.video.play();
    // What arrives is what is calibrated: on a turned device some browsers' settings still speak of the sensor.
    const { videoWidth, videoHeight } = parts.video;
    const key = { ...cameraKey(camera.track), img_size: /** @type {[number, number]} */ ([videoWidth, videoHeight]) };
    dispatch({ type: "opened", key, mirrored: camera.mirrored, cropped: camera.cropped });
    camera.track.addEventListener("ended", () => fail(new CameraError("The camera was unplugged."), signal));

    const { api, token } = await loadSettings();
    const finder = await openDetector();
    const session = new CaptureSession(
      new Api(api, { onPatience: (patience) => dispatch({ type: "patience", attempt: patience?.attempt ?? 0 }) }),
      token,
      {
        ...key, board: state.board, distortion_model: state.wanted.distortion_model, track: facts(camera.track),
        ...targetError(),
      },
    );
    dispatch({ type: "session", session: await session.start() });
    await new Guide(session, finder, camera, signal).run();
    own.abort();
  } catch (error) {
    fail(error, signal);
  }
}

/** What the session is to reach, where the address says so, px. */
function targetError() {
  const value = Number(parameters.get("target_error"));
  return value > 0 ? { target_error: value } : {};
}

/** @param {unknown} error @param {AbortSignal} signal of the run that it happened in */
function fail(error, signal) {
  if (signal.aborted) return;
  const known = [CameraError, ApiError, OfflineError, DetectorError].some((type) => error instanceof type);
  if (!known) console.error(error);
  const message = error instanceof Error ? error.message : String(error);
  run?.abort();
  dispatch({ type: "failed", message });
}

/** The loop of one capture. */
class Guide {
  #session;
  #detector;
  #camera;
  #signal;
  #focused = false;
  /** The conversation with the service that is going on. */
  #talk = Promise.resolve();

  /** @param {CaptureSession} session @param {Detector} detector @param {import("./camera.js").OpenCamera} camera @param {AbortSignal} signal */
  constructor(session, detector, camera, signal) {
    this.#session = session;
    this.#detector = detector;
    this.#camera = camera;
    this.#signal = signal;
    const on = (/** @type {HTMLElement} */ button, /** @type {() => void} */ action) =>
      button.addEventListener("click", action, { signal });
    on(parts.undo, () => this.#undo());
    on(parts.skip, () => this.#skip());
    document.addEventListener("keydown", (event) => this.#key(event), { signal });
  }

  /** Looks at one frame after the other until the session has converged. */
  async run() {
    this.#nextPose();
    while (state.phase === "capturing" && !this.#signal.aborted) {
      await nextFrame(parts.video);
      if (document.hidden || this.#signal.aborted) continue;
      const detection = await this.#detector.detect(await grab(parts.video));
      if (this.#signal.aborted) return;
      dispatch({ type: "frame", detection, time: performance.now() });
      this.#focus();
      const action = decide(state, performance.now());
      if (action === "submit") await this.#submit();
      else if (action === "skip") this.#nextPose({ skip: true });
    }
  }

  #focus() {
    const [columns, rows] = state.board.squares;
    if (this.#focused || state.corners.ids.length < FOCUSED * (columns - 1) * (rows - 1)) return;
    this.#focused = true;
    void lockFocus(this.#camera.track);
  }

  async #submit() {
    const { pose, key, corners } = state;
    if (!pose || !key) return;
    const detection = await this.#detector.detect(await grab(parts.video), { full: true });
    const { ids, points, size } = detection;
    // Between the two frames the device may have been turned, or the hold may have ended.
    if (!isOfSize(size, key)) return dispatch({ type: "frame", detection, time: performance.now() });
    const view = { ids, points };
    if (ids.length === 0 || motion(corners, view) > (STEADY * key.img_size[0]) / 1280) return;
    await this.#exclusive(async () => {
      const answer = await this.#session.submit(pose.index, view);
      this.#tell({ type: "answer", answer, corners: view, time: performance.now() });
    });
    if (state.phase === "capturing" && !state.pose) this.#nextPose();
  }

  /** @param {{skip?: boolean}} [options] */
  #nextPose(options) {
    return this.#exclusive(async () => {
      const { pose, picture } = await this.#session.pose(options);
      if (this.#signal.aborted) return;
      dispatch({ type: "pose", pose, picture: URL.createObjectURL(picture), time: performance.now() });
      this.#camera.virtual?.follow(pose);
    });
  }

  async #skip() {
    await this.#silence();
    if (state.phase === "capturing") await this.#nextPose({ skip: true });
  }

  async #undo() {
    await this.#silence();
    if (state.phase !== "capturing" || !state.session?.views.length) return;
    await this.#exclusive(async () => {
      this.#tell({ type: "undone", session: await this.#session.undo(), time: performance.now() });
    });
    await this.#nextPose();
  }

  /** What arrives after the run has ended is of no use to the next one. @param {Event} event */
  #tell(event) {
    if (!this.#signal.aborted) dispatch(event);
  }

  /** One conversation with the service at a time; what the page does by itself does not queue. @param {() => Promise<void>} action */
  #exclusive(action) {
    if (!state.busy) this.#talk = this.#converse(action);
    return this.#talk;
  }

  /** @param {() => Promise<void>} action */
  async #converse(action) {
    dispatch({ type: "busy" });
    try {
      await action();
      this.#tell({ type: "idle" });
    } catch (error) {
      fail(error, this.#signal);
    }
  }

  /** What a person asked for waits for its turn. */
  async #silence() {
    while (state.busy && !this.#signal.aborted) await this.#talk;
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "u" || event.key === "Backspace") void this.#undo();
    else if (event.key === "n") void this.#skip();
    else return;
    event.preventDefault();
  }
}

/** The next frame that the video shows. @param {HTMLVideoElement} video @returns {Promise<void>} */
function nextFrame(video) {
  return new Promise((resolve) => {
    // A camera that stalls, or a hidden tab, must not stop the loop for good.
    const timer = setTimeout(resolve, 500);
    const done = () => {
      clearTimeout(timer);
      resolve();
    };
    if (video.requestVideoFrameCallback) video.requestVideoFrameCallback(done);
    else requestAnimationFrame(done);
  });
}

function restart() {
  run?.abort();
  dispatch({ type: "restart" });
  void listCameras();
}

async function listCameras() {
  dispatch({ type: "cameras", cameras: await cameras(parameters) });
}

parts.start.addEventListener("click", () => capture(parts.camera.value));
parts.startVirtual.addEventListener("click", () => capture("virtual"));
for (const button of [parts.again, parts.onceMore, parts.stop]) button.addEventListener("click", restart);
navigator.mediaDevices?.addEventListener("devicechange", listCameras);
await listCameras();
if (parameters.has("virtual")) void capture("virtual");
// The detector arrives while the visitor reads. If it does not, capture() asks again and says why.
else openDetector().catch((error) => console.info("detector not loaded yet:", error.message));
