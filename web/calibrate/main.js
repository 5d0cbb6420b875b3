// The capture page: effects around the reducer. Events go in, `decide` says what to do, `render` shows it.
import { boardFrom, boardQuery } from "../board/geometry.js";
import { cameraKey } from "../sdk/calibdb.js";
import { SettingsError, loadSettings } from "../settings.js";
import { Api, ApiError, OfflineError } from "./api.js";
import { CameraError, cameras, facts, open } from "./camera.js";
import { Detector, DetectorError } from "./detector.js";
import { Guide } from "./guide.js";
import { findParts, render } from "./render.js";
import { CaptureSession } from "./session.js";
import { initial, reduce } from "./state.js";

/**
 * @typedef {import("./state.js").State} State
 * @typedef {import("./state.js").Event} Event
 */

const parameters = new URLSearchParams(location.search);
const parts = findParts();
const { board, problem } = boardFrom(parameters);

/** @type {State} */
let state = initial(board, wantedFrom(parameters));
/** @type {State | null} */
let shown = null;
/** One run of the capture; a new one makes all that is still on its way for the old one meaningless. */
/** @type {AbortController | null} */
let run = null;
/** @type {Promise<Detector> | null} */
let detector = null;
/** The capture that can be taken up again after a failure, and what it is about. @type {{about: string, session: CaptureSession} | null} */
let kept = null;
/** Id of the camera that was asked for last. */
let chosen = "";

/** @param {Event} event */
function dispatch(event) {
  state = reduce(state, event);
  render(parts, state, shown);
  if (shown?.picture && shown.picture !== state.picture) URL.revokeObjectURL(shown.picture);
  shown = state;
}

const page = { parts, state: () => state, dispatch, fail };

/** @param {URLSearchParams} query @returns {State["wanted"]} */
function wantedFrom(query) {
  const [, width, height] = /^(\d{1,5})[x×,](\d{1,5})$/.exec(query.get("img_size") ?? "") ?? [];
  return {
    camera: query.get("camera"),
    img_size: width ? [Number(width), Number(height)] : null,
    distortion_model: query.get("distortion_model") === "fisheye" ? "fisheye" : "rectilinear",
  };
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
  chosen = choice;
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

    dispatch({ type: "waiting", waiting: "detector" });
    const finder = await openDetector();
    if (signal.aborted) return;
    dispatch({ type: "waiting", waiting: "service" });
    const session = await converse(key, facts(camera.track), signal);
    if (state.phase === "capturing") await new Guide(page, { session, detector: finder, camera, signal }).run();
    own.abort();
  } catch (error) {
    fail(error, signal);
  }
}

/**
 * A session for this camera: the one that a failure interrupted, where it is about the same.
 * @param {import("../sdk/calibdb.js").CameraKey} key @param {ReturnType<typeof facts>} track @param {AbortSignal} signal
 */
async function converse(key, track, signal) {
  const { api: address, token } = await loadSettings();
  const api = new Api(address, {
    signal,
    onPatience: (patience) => signal.aborted || dispatch({ type: "patience", attempt: patience?.attempt ?? 0 }),
  });
  const request = { ...key, board: state.board, distortion_model: state.wanted.distortion_model, ...targetError() };
  const about = JSON.stringify(request);
  const same = kept?.about === about ? kept.session : null;
  const session = same ?? new CaptureSession(api, token, { ...request, track });
  const answer = same ? await same.resume(api) : await session.start();
  signal.throwIfAborted();
  kept = answer.status === "converged" ? null : { about, session };
  dispatch({ type: "session", session: answer });
  return session;
}

/** What the session is to reach, where the address says so, px. */
function targetError() {
  const value = Number(parameters.get("target_error"));
  return value > 0 ? { target_error: value } : {};
}

/** What is said to people in the words of the error itself. */
const TOLD = [CameraError, ApiError, OfflineError, DetectorError, SettingsError];

/** @param {unknown} error @param {AbortSignal} signal of the run that it happened in */
function fail(error, signal) {
  if (signal.aborted) return;
  run?.abort();
  if (error instanceof DetectorError) {
    void detector?.then((broken) => broken.close(), () => {});
    detector = null;
  }
  const told = TOLD.some((type) => error instanceof type);
  if (!told) console.error(error);
  const message = error instanceof Error ? error.message : String(error);
  dispatch({ type: "failed", message: told ? message : `Something went wrong in this page (${message}).` });
}

/** To the first sheet. What a failure interrupted is kept, what a person ended is not. @param {{keep: boolean}} options */
function restart({ keep }) {
  run?.abort();
  if (!keep) kept = null;
  dispatch({ type: "restart" });
  void listCameras();
}

function stop() {
  dispatch({ type: "stop", time: performance.now() });
  if (state.phase === "welcome") restart({ keep: false });
}

async function listCameras() {
  dispatch({ type: "cameras", cameras: await cameras(parameters) });
}

parts.start.addEventListener("click", () => capture(parts.camera.value));
for (const button of [parts.startVirtual, parts.failedVirtual]) button.addEventListener("click", () => capture("virtual"));
for (const button of [parts.cancel, parts.other]) button.addEventListener("click", () => restart({ keep: true }));
parts.again.addEventListener("click", () => capture(chosen));
parts.onceMore.addEventListener("click", () => restart({ keep: false }));
parts.stop.addEventListener("click", stop);
navigator.mediaDevices?.addEventListener("devicechange", listCameras);
parts.problem.textContent = problem;
parts.problem.hidden = problem === "";
for (const link of parts.boardLinks) link.search = boardQuery(board).toString();
await listCameras();
if (parameters.has("virtual")) void capture("virtual");
// The detector arrives while the visitor reads. If it does not, capture() asks again and says why.
else openDetector().catch((error) => console.info("detector not loaded yet:", error.message));
