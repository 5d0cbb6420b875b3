// Capture page: effects around the reducer. Events go in, `decide` says what to do, `render` shows the state.
import { boardFrom } from "../lib/board.js";
import { CameraError, cameras, deviceFault, open } from "../lib/camera.js";
import { Detector, DetectorError, PageDetector } from "../lib/detector.js";
import { language, onLanguage, t } from "../lib/i18n.js";
import { latest } from "../lib/latest.js";
import { openPage } from "../lib/page.js";
import { isVirtual } from "../lib/camera-name.js";
import { withDevice } from "../sdk/key.js";
import { Announcer, Feedback } from "../lib/capture/feedback.js";
import { acquireLock, heldLocks, openCaptureStore } from "../lib/capture/capture-store.js";
import { Stream } from "../lib/capture/streams.js";
import { Sizes, isLensDetected, modeName, nameBoard, offerLensTypes, takeSuggestion } from "./choices.js";
import { connectControls, findParts } from "./parts.js";
import { Film } from "./film.js";
import { showFirstSheet } from "./first-sheet.js";
import {
  RESUME,
  captureQuery,
  parseTargetError,
  parseWanted,
  resumeAt,
  showCaptureAddress,
  showResultAddress,
} from "./history.js";
import { initial, reduce } from "./reducer.js";
import { captureKey, plainNotice } from "./state.js";
import { render, renderChoice } from "./render.js";
import { isOffline } from "../lib/network.js";
import * as statusText from "./status-text.js";

/**
 * @import { OpenCamera } from "../lib/camera.js"
 * @import { SessionRequest } from "../vendor/api.js"
 * @import { Captures } from "./captures.js"
 * @import { Notice, State } from "./state.js"
 */

/**
 * @typedef {object} CaptureModules modules that are needed once a camera is open
 * @property {typeof import("./capture-loop.js").CaptureLoop} CaptureLoop
 * @property {typeof import("./capture-loop.js").loadPlan} loadPlan
 * @property {typeof import("./captures.js").serviceFault} serviceFault
 * @property {Captures} captures of this page and of earlier ones
 *
 * @typedef {Awaited<ReturnType<typeof openCamera>>} OpenedCamera
 */

openPage();
const parameters = new URLSearchParams(location.search);
const parts = findParts();
const { board, problem } = boardFrom(parameters);
const captureStore = openCaptureStore();
const film = new Film(parts.film, parts.video);
const feedback = new Feedback();
const announcer = new Announcer(parts.said);
/** Loaded while the visitor reads. @type {CaptureModules | null} */
let loaded = null;
/** View of the result: loaded during the capture. @type {import("./outcome.js").Outcome | null} */
let outcome = null;
/** @type {State} */
let state = initial(board, parseWanted(parameters));
/** @type {State | null} */
let shown = null;
/** The session of the last capture. @type {import("../lib/session.js").CaptureSession | null} */
let session = null;
/** Id of the camera that was requested last, and the size requested of it, px. */
let chosen = "";
let size = state.wanted.img_size ?? Sizes.USUAL;

/** @param {import("./state.js").Event} event */
function dispatch(event) {
  state = reduce(state, event);
  film.follow(event, state);
  if (isLensDetected(state)) return void changeModel();
  // Before the page shows the result sheet, which takes the focus: the outcome needs the camera's last frame.
  if (state.phase === "done" && shown?.phase !== "done") {
    outcome?.show(state);
    const returnTo = parameters.get("return_to");
    if (returnTo !== null)
      void import("./sender.js").then(({ showPracticeEnd }) => showPracticeEnd(parts, state, returnTo));
    showResultAddress(parameters, state);
  } else if (state.phase !== "done" && shown?.phase === "done") outcome?.clear();
  render(parts, state, shown);
  const {
    capture: { session: views },
    sight: { aim },
    link: { stored },
  } = state;
  if (views !== shown?.capture.session || aim !== shown?.sight.aim || stored !== shown?.link.stored) film.render(state);
  if (shown?.ui.picture && shown.ui.picture !== state.ui.picture) URL.revokeObjectURL(shown.ui.picture);
  giveFeedback(event, shown);
  shown = state;
}

/**
 * Gives feedback on an event: sounds, vibration, speech, and the live region.
 * @param {import("./state.js").Event} event
 * @param {State | null} before it, as the page shows it
 */
function giveFeedback(event, before) {
  if (state.phase === "done" && before?.phase !== "done") feedback.give("done");
  else if (event.type === "stored" || (event.type === "answer" && event.answer.accepted)) feedback.give("taken");
  else if (event.type === "answer") feedback.give("refused");
  if (state.phase !== "capturing") return;
  const hint = statusText.instruction(state);
  const { mismatchWarning, remedy, statusLine, notice } = statusText;
  const news = [mismatchWarning(state), statusLine(state), notice(state.ui.notice)];
  announcer.say([hint, remedy(state)].filter(Boolean).join(". "), ...news);
  feedback.say(hint);
}

const detector = new PageDetector(() =>
  Detector.open(state.board, (fraction) => dispatch({ type: "loading", fraction })),
);
const page = { parts, state: () => state, dispatch, fail, openDetector: () => detector.open() };

/**
 * @typedef {object} Opened
 * @property {Notice} [notice] why the capture was opened, shown as soon as it runs
 * @property {OpenCamera | null} [camera] the chosen camera, if it is open already
 */

/** One capture, from opening the camera to its end; a new one aborts the one before. */
const capture = latest(
  async (signal, /** @type {string} */ choice, /** @type {Opened} */ { notice, camera = null } = {}) => {
    chosen = choice;
    showCaptureAddress(parameters);
    dispatch({ type: "open", notice });
    try {
      const opened = await openCamera(signal, choice, camera);
      const request = await identify(opened, signal);
      const end = await run(opened, request, signal);
      if (signal.aborted) return;
      await finish(end, opened, request);
    } catch (error) {
      fail(error, signal);
    }
  },
);

/**
 * @param {AbortSignal} signal closes the camera, unless `finish` hands it to the next capture
 * @param {string} choice id of a camera @param {OpenCamera | null} opened that camera, if it is open already
 */
async function openCamera(signal, choice, opened) {
  loadCapture().catch(() => {}); // while the camera opens; `run` waits for it, and for its failure
  const camera = opened ?? (await open(choice, { parameters, board: state.board, place: document.body, size }));
  const stream = new Stream(camera);
  const keepOpen = stream.closeWith(signal, (error) => fail(error, signal));
  // Before permission, the browser's own choice had no id. From now on it is this camera.
  if (!camera.virtual) chosen = camera.track.getSettings().deviceId || choice;
  const [picture] = await stream.play([parts.video]);
  return { camera, stream, picture, keepOpen };
}

/**
 * Shows the open camera, and how it delivers.
 * @param {OpenedCamera} opened
 * @param {AbortSignal} signal
 * @returns {Promise<SessionRequest>}
 */
async function identify({ camera, picture }, signal) {
  const device = camera.virtual ? "" : await (await import("../lib/phone-model.js")).askPhoneModel(signal);
  signal.throwIfAborted();
  const { camera: label, size: img_size, platform, zoom, track } = picture;
  const key = { camera: label, platform: withDevice(platform, device), img_size, zoom };
  const request = { ...requestFor(key), track };
  dispatch({ type: "opened", key, request, mirrored: camera.mirrored, cropped: camera.cropped });
  return request;
}

/**
 * @param {OpenedCamera} opened @param {SessionRequest} request @param {AbortSignal} signal
 * @returns {Promise<"relayout" | null>} as `CaptureLoop.run`
 */
async function run({ stream }, request, signal) {
  if (!(await acquireLock(captureKey(request), signal))) throw new CameraError("elsewhere");
  dispatch({ type: "waiting", waiting: "service" });
  // The detector arrives while the session is opened and the first target is shown; the loop waits for it, and for its
  // failure.
  const finder = detector.open();
  finder.catch(() => {});
  const { CaptureLoop, loadPlan, captures } = await loadCapture();
  const plan = loadPlan().catch(() => []);
  await prepareOutcome();
  session = await openSession(captures, request, signal);
  if (state.phase !== "capturing") return null;
  const { camera: label, img_size } = request;
  if (!state.ui.notice && !isVirtual(label) && String(size) !== String(img_size)) {
    const notice = plainNotice("capture.got_size", { size: img_size.join(" × ") });
    dispatch({ type: "notice", notice, time: performance.now() });
  }
  return new CaptureLoop(page, { session, detector: finder, stream, plan: await plan, signal }).run();
}

/**
 * Ends a capture, or continues with another one of the same camera: of the board's other layout, or of the size that
 * a turned device delivers. The previous capture waits until the device is turned back.
 * @param {"relayout" | null} end @param {OpenedCamera} opened @param {SessionRequest} request
 */
async function finish(end, { camera, keepOpen }, request) {
  const isResized = state.phase === "failed" && state.failure?.code === "resized";
  if (isResized) {
    keepOpen();
    return void capture(chosen, { notice: plainNotice("capture.resized"), camera });
  }
  if (state.phase === "done") keepOpen();
  capture.cancel();
  if (state.phase === "done") outcome?.live(() => camera.close());
  if (end !== "relayout") return forgetCapture(captureKey(request));
  void continueWithBoard({ ...state.board, legacy: !state.board.legacy }, plainNotice("capture.legacy_taken"));
}

/** Starts again with another board. @param {State["board"]} other @param {Notice} notice */
function continueWithBoard(other, notice) {
  detector.close();
  dispatch({ type: "board", board: other });
  return capture(chosen, { notice });
}

/** Continues with the board in front of the camera. */
async function useBoard() {
  const seen = takeSuggestion(page, parameters);
  if (!seen) return;
  capture.cancel();
  await continueWithBoard(seen.board, seen.notice);
}

/** @returns {Promise<CaptureModules>} */
async function loadCapture() {
  const [{ CaptureLoop, loadPlan }, { Captures, serviceFault }] = await Promise.all([
    import("./capture-loop.js"),
    import("./captures.js"),
  ]);
  const page = { address: () => captureQuery(parameters), onUnsaved: () => dispatch({ type: "unsaved" }) };
  loaded ??= { CaptureLoop, loadPlan, serviceFault, captures: new Captures(captureStore, page) };
  return loaded;
}

/** Loads the modules that are needed once a capture is running. */
async function prepareOutcome() {
  const { Outcome } = await import("./outcome.js");
  outcome ??= new Outcome(parts.result, parts.video, {
    returnTo: parameters.get("return_to"),
    asked: state.wanted.camera,
    onAgain: () => capture(chosen),
    onWithout: continueWithout,
    onConsent: async (api) => session?.license(api),
    photo: (index) => film.picture(index),
  });
}

/** @param {import("../sdk/calibdb.js").CameraKey} key @returns {SessionRequest} without the track */
function requestFor(key) {
  const { distortion_model } = state.wanted;
  const mode_name = modeName(parts.modeName.value);
  return {
    ...key,
    board: state.board,
    distortion_model,
    ...parseTargetError(parameters),
    ...(mode_name ? { mode_name } : {}),
  };
}

/** @param {Captures} captures @param {SessionRequest} request @param {AbortSignal} signal */
async function openSession(captures, request, signal) {
  const onRetry = (/** @type {{attempt: number} | null} */ retry) =>
    signal.aborted || dispatch({ type: "retrying", attempts: retry?.attempt ?? 0 });
  const { session: opened, state: answer } = await captures.open(request, { signal, onRetry });
  signal.throwIfAborted();
  dispatch({ type: "request", request: opened.request });
  const time = performance.now();
  if (answer) dispatch({ type: "session", session: answer, stored: opened.waiting, time });
  else dispatch({ type: "opened-offline", stored: opened.size, time });
  return opened;
}

/**
 * Failure of a capture.
 * @param {unknown} error @returns {{code: string, detail: string}} code: of a message, `capture.fault_<code>`
 */
function failureOf(error) {
  const detail = error instanceof Error ? error.message : String(error);
  // Until the captures are loaded, no request can have failed.
  const fault = deviceFault(error) ?? loaded?.serviceFault(error);
  if (fault) return fault;
  if (isOffline(error)) return { code: "offline", detail };
  console.error(error);
  return { code: "unforeseen", detail };
}

/** @param {unknown} error @param {AbortSignal} signal of the capture that failed */
function fail(error, signal) {
  if (signal.aborted) return;
  capture.cancel();
  if (error instanceof DetectorError) detector.close();
  dispatch({ type: "failed", ...failureOf(error) });
}

/** Returns to the first sheet, which offers to resume what was interrupted. */
function restart() {
  capture.cancel();
  showCaptureAddress(parameters);
  dispatch({ type: "restart" });
  void listInterrupted().then(listCameras);
}

/**
 * Forgets a capture. Until the captures are loaded, this page has none besides the saved ones.
 * @param {string} about its key
 */
const forgetCapture = (about) => (loaded ? loaded.captures.forget(about) : captureStore.remove(about));

/** A capture that failed stays saved; one that a person ended does not. @param {State["capture"]["key"]} key */
async function end(key) {
  capture.cancel();
  if (key) await forgetCapture(captureKey(requestFor(key)));
  restart();
}

/** Starts again with the model that the service suggests, and with the same views. */
async function changeModel() {
  const model = state.capture.session?.suggested_model;
  if (!model) return;
  const { automatic } = state.wanted;
  capture.cancel();
  dispatch({ type: "model", model });
  parameters.set("distortion_model", (parts.lens.value = model));
  await continueWithout(
    [],
    automatic ? plainNotice("capture.lens_detected", { model: t(`capture.lens_${model}`) }) : undefined,
  );
}

/** Starts again with the same views, but for some. @param {number[]} indices @param {Notice} [notice] */
async function continueWithout(indices, notice) {
  const { key } = state.capture;
  if (!session || !key) return;
  capture.cancel();
  const { captures } = await loadCapture();
  await captures.move(session, requestFor(key), indices);
  await capture(chosen, { notice });
}

function stop() {
  const { key } = state.capture;
  dispatch({ type: "stop", time: performance.now() });
  if (state.phase === "welcome") void end(key);
}

async function listCameras() {
  dispatch({ type: "cameras", cameras: await cameras(parameters) });
  // A camera that was unplugged and is back is opened again without a click.
  const { phase, failure, ui } = state;
  const isUnplugged = phase === "failed" && failure?.code === "unplugged" && chosen !== "virtual";
  if (isUnplugged && ui.cameras.some(({ id }) => id === chosen)) void capture(chosen);
}

async function listInterrupted() {
  const last = await captureStore.last(await heldLocks());
  const interrupted = last && {
    camera: last.camera,
    views: last.views.length,
    about: last.about,
    address: last.address ?? captureQuery(parameters),
  };
  dispatch({ type: "interrupted", interrupted });
}

/** Resumes an interrupted capture at the address where it began, which names the board and the camera. */
async function resume() {
  const { interrupted, cameras: found } = state.ui;
  if (!interrupted) return;
  if (captureQuery(interrupted.address) !== captureQuery(parameters)) return resumeAt(interrupted.address);
  size = JSON.parse(interrupted.about).img_size;
  await capture(found.find(({ label }) => label === interrupted.camera)?.id ?? parts.camera.value);
}

async function forget() {
  if (state.ui.interrupted) await forgetCapture(state.ui.interrupted.about);
  await listInterrupted();
  parts.start.focus();
}

const sizes = new Sizes(parts.resolution, size);
const listed = listInterrupted().then(listCameras);
parts.start.addEventListener("click", async () => {
  await listed; // the visitor may click before the browser has listed its cameras
  size = sizes.chosen;
  void capture(parts.camera.value);
});
connectControls(parts, {
  resume,
  changeModel,
  restart,
  stop,
  forget,
  useBoard,
  listCameras,
  showChoice: () => renderChoice(parts),
  practise: () => capture("virtual"),
  again: () => capture(chosen),
  escape: () => state.phase === "opening" && restart(),
  wantBoard: () => dispatch({ type: "want-board" }),
  leavePractice: () => (parameters.delete("virtual"), restart()),
});
offerLensTypes(parts.lens, parameters, (choice) => dispatch({ type: "model", ...choice }));
feedback.bind(parts.senses);
onLanguage(() => {
  if (parameters.has("lang")) parameters.set("lang", language());
  sizes.write();
  render(parts, state, null);
  void listCameras();
});
showFirstSheet(parts, {
  board,
  problem,
  parameters,
  wanted: state.wanted,
  onBoard: (chosen) => {
    nameBoard(parameters, chosen);
    detector.close();
    dispatch({ type: "board", board: chosen });
  },
  onSender: () => render(parts, state, null),
});
await listed;
const isResumed = location.hash === RESUME;
showCaptureAddress(parameters);
if (isResumed) void resume();
else if (parameters.has("virtual")) void capture("virtual");
// What a capture needs loads while the visitor reads. If that fails, the capture tries again and says why.
else Promise.all([detector.open(), loadCapture()]).catch((error) => console.info("not loaded yet:", error.message));
