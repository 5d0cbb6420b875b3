// The capture page: effects around the reducer. Events go in, `decide` says what to do, `render` shows it.
import { boardFrom, boardQuery } from "../lib/board.js";
import { showProblem } from "../lib/board-problem.js";
import { language, onLanguage } from "../lib/i18n.js";
import { openPage } from "../lib/page.js";
import { cameraKey, platformHere } from "../sdk/key.js";
import { isVirtual } from "../lib/virtual/camera.js";
import captureWords from "../messages/capture.js";
import { Announcer } from "./announcer.js";
import { targetError, wantedFrom } from "./query.js";
import { CameraError, cameras, facts, open, play } from "../lib/camera.js";
import { Captures, captureKey } from "./captures.js";
import { acquireLock, heldLocks } from "./capture-lock.js";
import { Detector, DetectorError } from "../lib/detector.js";
import { openDrawers } from "./popovers.js";
import { failureOf } from "./failure.js";
import { Feedback } from "./feedback.js";
import { CaptureLoop } from "./capture-loop.js";
import { openCaptureStore } from "./capture-store.js";
import { loadPlan } from "./plan.js";
import { address, atCapture, atResult, GO_ON, goTo } from "./history.js";
import { findParts, render, renderChoice } from "./render.js";
import { Sizes } from "./sizes.js";
import { initial, reduce } from "./state.js";
import * as words from "./status-text.js";

/**
 * @typedef {import("./state.js").State} State
 * @typedef {import("./state.js").Event} Event
 * @typedef {import("../vendor/api.js").SessionRequest} Request
 */

openPage({ capture: captureWords });
const parameters = new URLSearchParams(location.search);
const parts = findParts();
const { board, problem } = boardFrom(parameters);
const captureStore = openCaptureStore();
const captures = new Captures(captureStore, { address: () => address(parameters), onUnkept: () => dispatch({ type: "unkept" }) });
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
/** The session of the last run. @type {import("../lib/session.js").CaptureSession | null} */
let session = null;
/** Id of the camera that was asked for last, and the size asked of it, px. */
let chosen = "";
let size = state.wanted.img_size ?? Sizes.USUAL;

/** @param {Event} event */
function dispatch(event) {
  state = reduce(state, event);
  // Before the page turns to it: it takes the focus, and the camera's last picture.
  if (state.phase === "done" && shown?.phase !== "done") {
    outcome?.show(state);
    atResult(parameters, state.session?.calibration_id ?? null);
  }
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
  announcer.say([hint, words.remedy(state)].filter(Boolean).join(". "), words.warning(state), words.standing(state), words.notice(state.notice));
  feedback.say(hint, language(), performance.now());
}

const page = { parts, state: () => state, dispatch, fail, openDetector };

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
 * @param {import("../lib/camera.js").OpenCamera | null} [opened] that camera, where it is open already
 */
async function capture(choice, opened = null) {
  run?.abort();
  const own = run = new AbortController();
  const { signal } = own;
  chosen = choice;
  atCapture(parameters);
  dispatch({ type: "open" });
  try {
    const camera = opened ?? await open(choice, {
      parameters, board: state.board, place: document.body, size,
    });
    const letGo = () => camera.close();
    signal.addEventListener("abort", letGo);
    if (signal.aborted) return letGo();
    // Before it was permitted the browser's own choice had no id: it is this camera from now on.
    if (!camera.virtual) chosen = camera.track.getSettings().deviceId || choice;
    await play(parts.video, camera.stream);
    // What arrives is what is calibrated: on a turned device some browsers' settings still speak of the sensor.
    const { videoWidth, videoHeight } = parts.video;
    const img_size = /** @type {[number, number]} */ ([videoWidth, videoHeight]);
    const key = { ...cameraKey(camera.track), platform: await platformHere(), img_size };
    const request = { ...requestFor(key), track: facts(camera.track) };
    dispatch({ type: "opened", key, request, mirrored: camera.mirrored, cropped: camera.cropped });
    camera.track.addEventListener("ended", () => fail(new CameraError("unplugged"), signal));

    if (!await acquireLock(captureKey(request), signal)) throw new CameraError("elsewhere");
    dispatch({ type: "waiting", waiting: "detector" });
    const plan = loadPlan().catch(() => []);
    const finder = await openDetector();
    if (signal.aborted) return;
    await prepareOutcome();
    dispatch({ type: "waiting", waiting: "service" });
    session = await converse(request, signal);
    if (state.phase === "capturing" && !state.notice && !isVirtual(key.camera) && String(size) !== String(img_size)) {
      tell("capture.got_size", { size: img_size.join(" × ") });
    }
    const means = { session, detector: finder, camera, plan: await plan, signal };
    const end = state.phase === "capturing" ? await new CaptureLoop(page, means).run() : null;
    if (signal.aborted) return;
    const resized = state.phase === "failed" && state.failure?.code === "resized";
    if (resized) signal.removeEventListener("abort", letGo);
    own.abort();
    if (resized) await again("capture.resized", camera);
    else if (end === "relayout") await relayout();
    else await captures.forget(captureKey(request));
  } catch (error) {
    fail(error, signal);
  }
}

/** What only a capture that goes on will need. */
async function prepareOutcome() {
  const { Outcome } = await import("./outcome.js");
  const onAgain = () => capture(chosen);
  outcome ??= new Outcome(parts.result, parts.video, { returnTo: parameters.get("return_to"), asked: state.wanted.camera, onAgain, onWithout: goOnWithout });
}

/**
 * Another capture of the same camera, with its reason. A device that was turned shows a picture of another size: that is
 * calibrated as such, and the capture before waits for the device to be turned back.
 * @param {string} why a text @param {import("../lib/camera.js").OpenCamera | null} [camera] where it stays open
 */
async function again(why, camera = null) {
  const begun = capture(chosen, camera);
  const told = setInterval(() => {
    if (state.phase === "opening") return;
    clearInterval(told);
    if (state.phase === "capturing") tell(why);
  }, 100);
  await begun;
}

/** @param {string} key of a text @param {Record<string, string | number>} [values] */
function tell(key, values) {
  dispatch({ type: "told", notice: { key, kind: "plain", values }, time: performance.now() });
}

/** The board that is shown has the other layout: that is the board, then. */
async function relayout() {
  void detector?.then((made) => made.close());
  detector = null;
  dispatch({ type: "board", board: { ...state.board, legacy: !state.board.legacy } });
  await again("capture.legacy_taken");
}

/** @param {import("../sdk/calibdb.js").CameraKey} key @returns {Request} what is sent of a capture, but its views */
function requestFor(key) {
  return { ...key, board: state.board, distortion_model: state.wanted.distortion_model, ...targetError(parameters) };
}

/** @param {Request} request @param {AbortSignal} signal */
async function converse(request, signal) {
  const onPatience = (/** @type {{attempt: number} | null} */ patience) =>
    signal.aborted || dispatch({ type: "patience", attempt: patience?.attempt ?? 0 });
  const { session, state: answer } = await captures.open(request, { signal, onPatience });
  signal.throwIfAborted();
  dispatch({ type: "request", request: session.request });
  if (answer) dispatch({ type: "session", session: answer, stored: session.waiting });
  else dispatch({ type: "offline", stored: session.size });
  return session;
}

/** @param {unknown} error @param {AbortSignal} signal of the run that it happened in */
function fail(error, signal) {
  if (signal.aborted) return;
  run?.abort();
  if (error instanceof DetectorError) {
    void detector?.then((broken) => broken.close(), () => {});
    detector = null;
  }
  dispatch({ type: "failed", ...failureOf(error) });
}

/** To the first sheet, where what was interrupted is offered again. */
function restart() {
  run?.abort();
  atCapture(parameters);
  dispatch({ type: "restart" });
  void listInterrupted().then(listCameras);
}

/** What a failure interrupted is kept; what a person ended is not. @param {State["key"]} key */
async function end(key) {
  run?.abort();
  if (key) await captures.forget(captureKey(requestFor(key)));
  restart();
}

/** Once more, with the model that the service suggests. */
async function changeModel() {
  const model = state.session?.suggested_model;
  if (!model) return;
  run?.abort();
  dispatch({ type: "model", model: /** @type {State["wanted"]["distortion_model"]} */ (model) });
  parameters.set("distortion_model", model);
  await goOnWithout([]);
}

/** Once more with the views that there are, but for some. @param {number[]} indices */
async function goOnWithout(indices) {
  if (!session || !state.key) return;
  run?.abort();
  await captures.move(session, requestFor(state.key), indices);
  await capture(chosen);
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
  const kept = await captureStore.last(await heldLocks());
  dispatch({
    type: "interrupted",
    interrupted: kept && { camera: kept.camera, views: kept.views.length, about: kept.about, address: kept.address ?? address(parameters) },
  });
}

/** Goes on with what was interrupted: on the page that it was begun on, since that says what it is of. */
async function goOn() {
  const { interrupted } = state;
  if (!interrupted) return;
  if (address(interrupted.address) !== address(parameters)) return goTo(interrupted.address);
  size = JSON.parse(interrupted.about).img_size;
  await capture(state.cameras.find(({ label }) => label === interrupted.camera)?.id ?? parts.camera.value);
}

async function forget() {
  if (state.interrupted) await captures.forget(state.interrupted.about);
  await listInterrupted();
  parts.start.focus();
}

const sizes = new Sizes(parts.resolution, size);
const listed = listInterrupted().then(listCameras);
parts.start.addEventListener("click", async () => {
  await listed; // who is quicker than the browser gets the camera that was asked for all the same
  size = sizes.chosen;
  void capture(parts.camera.value);
});
parts.goOn.addEventListener("click", goOn);
for (const button of parts.models) button.addEventListener("click", changeModel);
parts.camera.addEventListener("change", () => renderChoice(parts));
openDrawers(() => state.phase === "opening" && restart());
for (const button of [parts.startVirtual, parts.failedVirtual]) button.addEventListener("click", () => capture("virtual"));
for (const button of [parts.cancel, parts.other]) button.addEventListener("click", restart);
parts.again.addEventListener("click", () => capture(chosen));
// Who presses twice in haste means it once, where what is lost does not come back.
for (const [button, action] of /** @type {const} */ ([[parts.stop, stop], [parts.forget, forget]])) {
  button.addEventListener("click", ({ detail }) => detail < 2 && action());
}
for (const [sense, box] of /** @type {[import("./feedback.js").Sense, HTMLInputElement][]} */ (Object.entries(parts.senses))) {
  box.checked = feedback.has(sense);
  box.parentElement?.toggleAttribute("hidden", !Feedback.offers(sense));
  box.addEventListener("change", () => feedback.switch(sense, box.checked));
}
onLanguage(() => {
  if (parameters.has("lang")) parameters.set("lang", language());
  sizes.write();
  render(parts, state, null);
  void listCameras();
});
navigator.mediaDevices?.addEventListener("devicechange", listCameras);
// A phone may have taken the camera away meanwhile.
document.addEventListener("visibilitychange", () => document.hidden || void listCameras());
showProblem(parts.problem, problem);
for (const link of parts.boardLinks) link.search = boardQuery(board).toString();
await listed;
const onward = location.hash === GO_ON;
atCapture(parameters);
if (onward) void goOn();
else if (parameters.has("virtual")) void capture("virtual");
// The detector arrives while the visitor reads. If it does not, capture() asks again and says why.
else openDetector().catch((error) => console.info("detector not loaded yet:", error.message));
