// The capture page: effects around the reducer. Events go in, `decide` says what to do, `render` shows it.
import { boardFrom, boardQuery } from "../board/geometry.js";
import { showProblem } from "../board/problem.js";
import { language, onLanguage } from "../i18n.js";
import { openPage } from "../page.js";
import { cameraKey, platformHere } from "../sdk/calibdb.js";
import { SettingsError, loadSettings } from "../settings.js";
import captureWords from "../words/capture.js";
import { Announcer } from "./announcer.js";
import { Api, ApiError, OfflineError } from "./api.js";
import { CameraError, cameras, facts, open } from "./camera.js";
import { Detector, DetectorError } from "./detector.js";
import { Feedback } from "./feedback.js";
import { Guide } from "./guide.js";
import { openCupboard } from "./kept.js";
import { loadPlan } from "./plan.js";
import { findParts, render } from "./render.js";
import { CaptureSession } from "./session.js";
import { initial, reduce } from "./state.js";
import * as words from "./words.js";

/**
 * @typedef {import("./state.js").State} State
 * @typedef {import("./state.js").Event} Event
 * @typedef {import("../vendor/api.js").SessionRequest} Request
 */

/** ms that a fit of fifteen views takes at most, ten times over: who is silent for longer is away. */
const ANSWER = 10_000;

openPage({ capture: captureWords });
const parameters = new URLSearchParams(location.search);
const parts = findParts();
const { board, problem } = boardFrom(parameters);
const cupboard = openCupboard();
const feedback = new Feedback();
const announcer = new Announcer(parts.said);
/** What shows the result: it arrives while the capture goes on. @type {import("./outcome.js").Outcome | null} */
let outcome = null;

/** @type {State} */
let state = initial(board, wantedFrom(parameters));
/** @type {State | null} */
let shown = null;
/** One run of the capture; a new one makes all that is still on its way for the old one meaningless. */
/** @type {AbortController | null} */
let run = null;
/** @type {Promise<Detector> | null} */
let detector = null;
/** The captures of this page, by what they are about: each can be taken up again. @type {Map<string, CaptureSession>} */
const sessions = new Map();
/** Id of the camera that was asked for last. */
let chosen = "";

/** @param {Event} event */
function dispatch(event) {
  state = reduce(state, event);
  // Before the page turns to it: it takes the focus, and the camera's last picture.
  if (state.phase === "done" && shown?.phase !== "done") outcome?.show(state);
  else if (state.phase !== "done" && shown?.phase === "done") outcome?.clear();
  render(parts, state, shown);
  if (shown?.picture && shown.picture !== state.picture) URL.revokeObjectURL(shown.picture);
  signal(event);
  shown = state;
}

/** What is heard and felt. @param {Event} event */
function signal(event) {
  if (state.phase === "done" && shown?.phase !== "done") feedback.give("done");
  else if (event.type === "stored" || (event.type === "answer" && event.answer.accepted)) feedback.give("taken");
  else if (event.type === "answer") feedback.give("refused");
  if (state.phase !== "capturing") return;
  const hint = words.instruction(state);
  announcer.say([words.notice(state.notice), hint, words.remedy(state)].filter(Boolean).join(". "));
  feedback.say(hint, language(), performance.now());
}

const page = { parts, state: () => state, dispatch, fail, openDetector };

/** @param {URLSearchParams} query @returns {State["wanted"]} */
function wantedFrom(query) {
  const [, width, height] = /^(\d{1,5})[x×,](\d{1,5})$/.exec(query.get("img_size") ?? "") ?? [];
  const model = query.get("distortion_model");
  return {
    camera: query.get("camera"),
    img_size: width ? [Number(width), Number(height)] : null,
    distortion_model: model === "fisheye" || model === "rational" || model === "omnidirectional" ? model : "rectilinear",
  };
}

/** OpenCV is loaded once; a detector that failed is made anew. @returns {Promise<Detector>} */
function openDetector() {
  const last = detector;
  detector = (last ?? Promise.reject(new DetectorError("none yet")))
    .then((made) => (made.closed ? Promise.reject(new DetectorError("closed")) : made))
    .catch(() => Detector.open(state.board, (fraction) => dispatch({ type: "loading", fraction })));
  detector.catch(() => {
    detector = null;
  });
  return detector;
}

/**
 * @param {string} choice id of a camera
 * @param {import("./camera.js").OpenCamera | null} [opened] that camera, where it is open already
 */
async function capture(choice, opened = null) {
  run?.abort();
  const own = run = new AbortController();
  const { signal } = own;
  chosen = choice;
  dispatch({ type: "open" });
  try {
    const camera = opened ?? await open(choice, {
      parameters, board: state.board, place: document.body, size: state.wanted.img_size ?? [1280, 720],
    });
    const letGo = () => camera.close();
    signal.addEventListener("abort", letGo);
    if (signal.aborted) return letGo();
    parts.video.srcObject = camera.stream;
    await parts.video.play();
    // What arrives is what is calibrated: on a turned device some browsers' settings still speak of the sensor.
    const { videoWidth, videoHeight } = parts.video;
    const img_size = /** @type {[number, number]} */ ([videoWidth, videoHeight]);
    const key = { ...cameraKey(camera.track), platform: await platformHere(), img_size };
    dispatch({ type: "opened", key, track: facts(camera.track), mirrored: camera.mirrored, cropped: camera.cropped });
    camera.track.addEventListener("ended", () => fail(new CameraError("unplugged"), signal));

    dispatch({ type: "waiting", waiting: "detector" });
    const plan = loadPlan().catch(() => []);
    const finder = await openDetector();
    if (signal.aborted) return;
    await prepareOutcome();
    dispatch({ type: "waiting", waiting: "service" });
    const session = await converse(key, facts(camera.track), signal);
    const means = { session, detector: finder, camera, plan: await plan, signal };
    const end = state.phase === "capturing" ? await new Guide(page, means).run() : null;
    if (signal.aborted) return;
    const resized = state.phase === "failed" && state.failure?.code === "resized";
    if (resized) signal.removeEventListener("abort", letGo);
    own.abort();
    if (resized) await again("capture.resized", camera);
    else if (end === "relayout") await relayout();
    else await cupboard.remove(aboutOf(key));
  } catch (error) {
    fail(error, signal);
  }
}

/** What only a capture that goes on will need. */
async function prepareOutcome() {
  const { Outcome } = await import("./outcome.js");
  outcome ??= new Outcome(parts.result, parts.video, { returnTo: parameters.get("return_to"), onAgain: () => end(state.key) });
}

/**
 * Another capture of the same camera, with its reason. A device that was turned shows a picture of another size: that is
 * calibrated as such, and the capture before waits for the device to be turned back.
 * @param {string} why a text @param {import("./camera.js").OpenCamera | null} [camera] where it stays open
 */
async function again(why, camera = null) {
  const begun = capture(chosen, camera);
  const told = setInterval(() => {
    if (state.phase === "opening") return;
    clearInterval(told);
    if (state.phase === "capturing") dispatch({ type: "told", notice: { key: why, kind: "plain" }, time: performance.now() });
  }, 100);
  await begun;
}

/** The board that is shown has the other layout: that is the board, then. */
async function relayout() {
  void detector?.then((made) => made.close());
  detector = null;
  dispatch({ type: "board", board: { ...state.board, legacy: !state.board.legacy } });
  await again("capture.legacy_taken");
}

/** @param {import("../sdk/calibdb.js").CameraKey} key */
function requestFor(key) {
  return { ...key, board: state.board, distortion_model: state.wanted.distortion_model, ...targetError() };
}

/** @param {import("../sdk/calibdb.js").CameraKey} key what a capture is about, as text */
const aboutOf = (key) => JSON.stringify(requestFor(key));

/**
 * A session for this camera: one that was interrupted, on this page or an earlier one, where it is about the same.
 * @param {import("../sdk/calibdb.js").CameraKey} key @param {ReturnType<typeof facts>} track @param {AbortSignal} signal
 */
async function converse(key, track, signal) {
  const { api: address, token } = await loadSettings();
  const api = new Api(address, {
    signal,
    patience: ANSWER,
    onPatience: (patience) => signal.aborted || dispatch({ type: "patience", attempt: patience?.attempt ?? 0 }),
  });
  const about = aboutOf(key);
  const before = await cupboard.load(about);
  const same = sessions.get(about);
  const session = same ?? new CaptureSession(api, token, /** @type {Request} */ ({ ...requestFor(key), track }), { about, kept: before, save });
  const answer = same || before?.views.length ? (await session.resume(api, { patient: true })).state : await session.start();
  signal.throwIfAborted();
  sessions.set(about, session);
  if (answer.status === "converged") sessions.delete(about);
  dispatch({ type: "session", session: answer, stored: session.waiting });
  return session;
}

/** @param {import("./session.js").Kept} kept */
async function save(kept) {
  const saved = kept.views.length ? await cupboard.save(kept) : (await cupboard.remove(kept.about), true);
  if (!saved) dispatch({ type: "unkept" });
}

/** What the session is to reach, where the address says so, px. */
function targetError() {
  const value = Number(parameters.get("target_error"));
  return value > 0 ? { target_error: value } : {};
}

/** @param {unknown} error @returns {{code: string, detail: string}} */
function told(error) {
  const detail = error instanceof Error ? error.message : String(error);
  if (error instanceof CameraError) return { code: error.code, detail: error.detail };
  if (error instanceof DetectorError) return { code: error.code, detail };
  if (error instanceof OfflineError) return { code: "offline", detail };
  if (error instanceof SettingsError) return { code: "settings", detail };
  if (error instanceof ApiError) return { code: "service", detail };
  console.error(error);
  return { code: "unforeseen", detail };
}

/** @param {unknown} error @param {AbortSignal} signal of the run that it happened in */
function fail(error, signal) {
  if (signal.aborted) return;
  run?.abort();
  if (error instanceof DetectorError) {
    void detector?.then((broken) => broken.close(), () => {});
    detector = null;
  }
  dispatch({ type: "failed", ...told(error) });
}

/** To the first sheet, where what was interrupted is offered again. */
function restart() {
  run?.abort();
  dispatch({ type: "restart" });
  void listCameras();
  void listInterrupted();
}

/** What a failure interrupted is kept; what a person ended is not. @param {State["key"]} key */
async function end(key) {
  run?.abort();
  if (key) {
    sessions.delete(aboutOf(key));
    await cupboard.remove(aboutOf(key));
  }
  restart();
}

function stop() {
  const { key } = state;
  dispatch({ type: "stop", time: performance.now() });
  if (state.phase === "welcome") void end(key);
}

async function listCameras() {
  dispatch({ type: "cameras", cameras: await cameras(parameters) });
  // The camera that was pulled out is there again: nobody has to press anything.
  const { phase, failure } = state;
  if (phase === "failed" && failure?.code === "unplugged" && chosen !== "virtual" && state.cameras.some(({ id }) => id === chosen)) {
    void capture(chosen);
  }
}

async function listInterrupted() {
  const kept = await cupboard.last();
  dispatch({ type: "interrupted", interrupted: kept && { camera: kept.camera, views: kept.views.length } });
}

async function forget() {
  for (let kept = await cupboard.last(); kept; kept = await cupboard.last()) await cupboard.remove(kept.about);
  sessions.clear();
  await listInterrupted();
  parts.start.focus();
}

parts.start.addEventListener("click", () => capture(parts.camera.value));
for (const button of [parts.startVirtual, parts.failedVirtual]) button.addEventListener("click", () => capture("virtual"));
for (const button of [parts.cancel, parts.other]) button.addEventListener("click", restart);
parts.again.addEventListener("click", () => capture(chosen));
parts.stop.addEventListener("click", stop);
parts.forget.addEventListener("click", forget);
for (const [sense, box] of /** @type {[import("./feedback.js").Sense, HTMLInputElement][]} */ (Object.entries(parts.senses))) {
  box.checked = feedback.has(sense);
  box.parentElement?.toggleAttribute("hidden", !Feedback.offers(sense));
  box.addEventListener("change", () => feedback.switch(sense, box.checked));
}
onLanguage(() => render(parts, state, null));
navigator.mediaDevices?.addEventListener("devicechange", listCameras);
showProblem(parts.problem, problem);
for (const link of parts.boardLinks) link.search = boardQuery(board).toString();
await listCameras();
await listInterrupted();
if (parameters.has("virtual")) void capture("virtual");
// The detector arrives while the visitor reads. If it does not, capture() asks again and says why.
else openDetector().catch((error) => console.info("detector not loaded yet:", error.message));
