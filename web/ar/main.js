// Page /ar/, which shows what a calibration is for: the same drawing in three ways over the camera's picture.
import { boardFrom, boardQuery } from "../lib/board.js";
import { showProblem } from "../lib/board-text.js";
import { CameraError, cameras, deviceFaultText, offerCameras, open, play } from "../lib/camera.js";
import { Detector, DetectorError, PageDetector } from "../lib/detector.js";
import { part, sayFailure } from "../lib/dom.js";
import { explain } from "../lib/faults.js";
import { onLanguage, rough, t } from "../lib/i18n.js";
import { openPage } from "../lib/page.js";
import { phoneModel } from "../lib/phone-model.js";
import { keyOf } from "../sdk/key.js";
import { lensOf } from "../sdk/projection.js";
import { RectifierError } from "../sdk/warp.js";
import { isVirtual } from "../lib/camera-name.js";
import { Live } from "./live.js";
import { MODES } from "./modes.js";
import { calibrationOf, estimateOf } from "./source.js";
import { stopAt } from "./tour.js";

/** @import { Misalignment } from "./live.js" */

const SHEETS = ["welcome", "opening", "unknown", "failed"];
const NUMBER_INTERVAL_MS = 250; // ms between two numbers: faster ones are not readable
const MAX_RESTARTS = 3; // of the detector in one run: a fourth would not help
/** @type {[number, number]} */
const SIZE = [1280, 720];

openPage();
const parameters = new URLSearchParams(location.search);
const { board, problem } = boardFrom(parameters);
const html = (/** @type {string} */ id) => part(id, HTMLElement);
const [video, camera, balance] = [
  part("video", HTMLVideoElement),
  part("camera", HTMLSelectElement),
  part("balance", HTMLInputElement),
];
const [stage, layers, rms, outermost] = [html("stage"), html("layers"), html("rms"), html("outermost")];
const modes = /** @type {HTMLButtonElement[]} */ ([...html("modes").children]);

/** Facts that the texts show; after a change of language, they are written again. */
const said = {
  phase: "welcome",
  waiting: "camera",
  origin: "",
  label: "",
  size: "",
  error: /** @type {unknown} */ (null),
  estimate: /** @type {import("./source.js").Estimate | null} */ (null),
  hfov: /** @type {number | null} */ (null),
  failed: "", // why the estimate is missing
  off: /** @type {Misalignment} */ (null),
};
/** Run of one camera; a new run aborts the pending work of the old one. */
let run = new AbortController();
const detector = new PageDetector(() =>
  Detector.open(board, (fraction) => {
    html("loading-meter").hidden = fraction >= 1;
    part("loading", HTMLProgressElement).value = fraction;
  }),
);
/** @type {Live | null} */
let live = null;
/** @type {() => void} */
let moveOn = () => {};
let mode = "matrix";
let reportedAt = -Infinity;
let chosen = "";
/** @type {import("../sdk/calibdb.js").CameraKey | null} of the camera that is open */
let cameraKey = null;

/** @param {string} phase a sheet's name, or "live" @param {Partial<typeof said>} [more] */
function turnTo(phase, more = {}) {
  const moved = phase !== said.phase;
  Object.assign(said, { phase, ...more });
  for (const name of SHEETS) html(name).hidden = name !== phase;
  html("reticle").hidden = html("controls").hidden = phase !== "live";
  write();
  // The focused element is gone: the focus moves to the title of the new sheet.
  if (moved) html(`${phase}-title`).focus();
}

function write() {
  const { phase, waiting, label, size, origin, error } = said;
  const name = `${isVirtual(label) ? t("ar.virtual") : label}, ${size}`;
  html("opening-text").textContent = t(waiting === "lookup" ? "ar.looking_up" : `capture.opening_${waiting}`);
  html("unknown-text").textContent = phase === "unknown" ? t("ar.unknown_text", { camera: name }) : "";
  sayFailure(html("failure"), phase === "failed" ? errorText(error) : "");
  html("facts").textContent = phase === "live" ? `${name} · ${t(`ar.origin_${origin}`)}` : "";
  html("recalibrate").hidden = phase !== "live" || origin === "returned";
  writeOff();
}

function writeOff() {
  const { off } = said;
  html("instruction").hidden = off !== null;
  html("instruction").textContent = off ? "" : t("capture.say_show");
  rms.textContent = off ? t("ar.rms", { px: rough(off.rms) }) : "";
  outermost.textContent = said.failed || (off ? offText(off.outermost) : "");
}

/** @param {number} outermost px */
function offText(outermost) {
  const { estimate, hfov: calibrated } = said;
  if (mode !== "estimate" || !estimate) return t("ar.outermost", { px: rough(outermost) });
  const [low, high] = estimate.interval_90.hfov_deg;
  const degrees = (/** @type {number} */ value) => String(Math.round(value));
  return t("ar.estimate_off", {
    px: rough(outermost),
    value: degrees(estimate.hfov_deg),
    low: degrees(low),
    high: degrees(high),
    calibrated: degrees(calibrated ?? 0),
  });
}

/** Horizontal field of view, degrees. @param {import("../sdk/rectification.js").Calibration} calibration */
function hfov(calibration) {
  const { img_size, camera_matrix } = calibration;
  const lens = lensOf(calibration);
  const [left, right] = [-0.5, img_size[0] - 0.5].map((x) => lens.unproject([x, camera_matrix[1][2]]));
  if (!left || !right) return null;
  const cosine = left[0] * right[0] + left[1] * right[1] + left[2] * right[2];
  return (Math.acos(cosine / (Math.hypot(...left) * Math.hypot(...right))) * 180) / Math.PI;
}

/** @param {unknown} error */
function errorText(error) {
  const fault = deviceFaultText(error);
  if (fault) return fault;
  if (error instanceof RectifierError) return t(error.lost ? "ar.gpu_lost" : "ar.no_webgl");
  return explain(error);
}

/** @param {Misalignment} off @param {string} shown the mode of the picture that is shown */
function tell(off, shown) {
  stage.dataset.shown = shown;
  const now = performance.now();
  if (now - reportedAt < NUMBER_INTERVAL_MS && (off === null) === (said.off === null)) return;
  reportedAt = now;
  said.off = off;
  writeOff();
}

/** @param {string} choice id of a camera */
async function start(choice) {
  run.abort();
  const own = (run = new AbortController());
  const { signal } = own;
  chosen = choice;
  turnTo("opening", { waiting: "camera", off: null });
  try {
    const opened = await open(choice, { parameters, board, place: document.body, size: SIZE });
    signal.addEventListener("abort", () => opened.close());
    if (signal.aborted) return opened.close();
    // Before permission, the browser's own choice had no id. From now on it is this camera.
    if (!opened.virtual) chosen = opened.track.getSettings().deviceId || choice;
    opened.track.addEventListener("ended", () => fail(new CameraError("unplugged"), signal));
    await play(video, opened.stream);
    stage.classList.toggle("mirrored", opened.mirrored);
    // A picture that changes its size, as when a phone is turned, counts as another camera.
    let restarts = 0;
    for (let end = "resized"; end && !signal.aborted;) {
      end = await show(opened, signal, restarts < MAX_RESTARTS);
      if (end === "stopped") restarts += 1;
    }
  } catch (error) {
    fail(error, signal);
  }
}

/**
 * @param {import("../lib/camera.js").OpenCamera} opened @param {AbortSignal} signal
 * @param {boolean} restarts whether another detector may take the place of one that stops
 * @returns {Promise<"resized" | "stopped" | "">}
 */
async function show({ track, virtual }, signal, restarts) {
  turnTo("opening", { waiting: "lookup" });
  const img_size = /** @type {[number, number]} */ ([video.videoWidth, video.videoHeight]);
  const key = { ...(await keyOf(track, phoneModel())), img_size };
  const { calibration, origin, guidance } = await calibrationOf(key, parameters);
  if (signal.aborted) return "";
  for (const id of ["calibrate", "recalibrate"]) part(id, HTMLAnchorElement).href = guidance;
  Object.assign(said, { label: key.camera, size: img_size.join(" × "), origin, estimate: null, failed: "" });
  cameraKey = key;
  if (mode === "estimate") draw("matrix");
  if (!calibration) {
    turnTo("unknown");
    run.abort();
    return "";
  }
  said.hfov = hfov(calibration);
  turnTo("opening", { waiting: "loading" });
  const finder = await detector.open();
  if (signal.aborted) return "";
  let stop = 0;
  moveOn = () => virtual?.follow(stopAt(board, calibration, stop++));
  moveOn();
  html("move").hidden = !virtual;
  const shown = (live = new Live({
    video,
    layers,
    board,
    detector: finder,
    calibration,
    mode,
    balance: Number(balance.value),
  }));
  turnTo("live");
  try {
    return (await shown.run(signal, tell)) ?? "";
  } catch (error) {
    if (!(error instanceof DetectorError) || signal.aborted || !restarts) throw error;
    console.info("the detector is restarted:", error.message);
    detector.close();
    return "stopped";
  } finally {
    shown.dispose();
    if (live === shown) live = null; // the next run may have begun already
  }
}

/** @param {unknown} error @param {AbortSignal} signal of the run that it happened in */
function fail(error, signal) {
  if (signal.aborted) return;
  run.abort();
  if (error instanceof DetectorError) detector.close();
  turnTo("failed", { error });
}

/** Draws in another mode; the estimate is fetched when it is first needed. @param {string} name */
async function choose(name) {
  const [{ signal }, key] = [run, cameraKey];
  if (name === "estimate" && !said.estimate && key) {
    try {
      const estimate = await estimateOf(key);
      if (signal.aborted || !live) return;
      said.estimate = live.estimate = estimate;
    } catch (error) {
      if (signal.aborted) return;
      said.failed = explain(error);
      return writeOff();
    }
  }
  said.failed = "";
  draw(name);
}

/** @param {string} name of a mode */
function draw(name) {
  mode = name;
  for (const button of modes) button.setAttribute("aria-pressed", String(button.value === name));
  balance.disabled = name !== "rectified";
  reportedAt = -Infinity;
  redraw((shown) => shown.mode(name));
}

/** @param {(shown: Live) => Misalignment} how the same picture is shown in another way */
function redraw(how) {
  try {
    if (live) tell(how(live), mode);
  } catch (error) {
    fail(error, run.signal);
  }
}

async function listCameras() {
  const choices = await cameras(parameters);
  const none = offerCameras(camera, choices, parameters.get("camera"));
  html("start").classList.toggle("primary", !none);
  for (const button of html("welcome").querySelectorAll(".virtually")) button.classList.toggle("primary", none);
  // The unplugged camera is back: the page restarts it without a click.
  const { phase, error } = said;
  const missed =
    phase === "failed" && error instanceof CameraError && error.code === "unplugged" && chosen !== "virtual";
  if (missed && choices.some(({ id }) => id === chosen)) void start(chosen);
}

function restart() {
  run.abort();
  turnTo("welcome");
  void listCameras();
}

for (const button of modes) button.addEventListener("click", () => choose(button.value));
balance.addEventListener("input", () => redraw((shown) => shown.balance(Number(balance.value))));
document.addEventListener("keydown", (event) => {
  if (said.phase !== "live" || event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.target instanceof Element && event.target.closest("input, select")) return;
  const named = Object.keys(MODES)[Number(event.key) - 1];
  if (named) void choose(named);
  else if (event.key.toLowerCase() === "m") moveOn();
});
html("move").addEventListener("click", () => moveOn());
const listed = listCameras();
html("start").addEventListener("click", async () => {
  await listed; // a visitor may press the button before the cameras are listed
  void start(camera.value);
});
html("again").addEventListener("click", () => start(chosen));
for (const button of document.querySelectorAll(".virtually")) button.addEventListener("click", () => start("virtual"));
for (const button of document.querySelectorAll(".elsewhere")) button.addEventListener("click", restart);
for (const link of /** @type {NodeListOf<HTMLAnchorElement>} */ (document.querySelectorAll("a.board")))
  link.search = boardQuery(board).toString();
navigator.mediaDevices?.addEventListener("devicechange", listCameras);
// A phone may have taken the camera away meanwhile.
document.addEventListener("visibilitychange", () => document.hidden || void listCameras());
onLanguage(() => {
  write();
  void listCameras();
});
showProblem(html("problem"), problem);
await listed;
detector.open().catch((error) => console.info("detector not loaded yet:", error.message));
const returning = location.hash.includes("calibration=");
if (parameters.has("virtual")) void start("virtual");
else if (returning && camera.value) void start(camera.value);
