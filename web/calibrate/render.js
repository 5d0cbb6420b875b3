// Puts the state into the page. Reads nothing back, decides nothing.
import { t } from "../lib/i18n.js";
import { isVirtual } from "../lib/virtual/camera.js";
import { propose } from "../lib/camera.js";
import { holdProgress, requiredHold } from "./hold.js";
import { renderSeen, renderTarget } from "./overlay-layer.js";
import { viewCount } from "../lib/session.js";
import * as words from "./status-text.js";

/** @typedef {import("./state.js").State} State */

/** @template {Element} E @param {string} id @param {new () => E} type @returns {E} */
function element(id, type) {
  const found = document.getElementById(id);
  if (!(found instanceof type)) throw new TypeError(`the page has no ${type.name} #${id}`);
  return found;
}

/** The page's parts, found once: a page that lacks one says so at once. */
export function findParts() {
  const html = (/** @type {string} */ id) => element(id, HTMLElement);
  const svg = (/** @type {string} */ id) => element(id, SVGElement);
  return {
    sheets: { welcome: html("welcome"), opening: html("opening"), failed: html("failed"), done: html("done") },
    stage: html("stage"), video: element("video", HTMLVideoElement), overlay: element("overlay", HTMLImageElement),
    marks: svg("marks"), pictureEdge: svg("picture-edge"), target: svg("target"), targetBack: svg("target-back"), targetCorner: svg("target-corner"),
    corners: svg("corners"), held: svg("held"), ring: svg("ring"), ghost: svg("ghost"), arrows: svg("arrows"), seenOutline: svg("seen-outline"),
    reticle: html("reticle"), instruction: html("instruction"), notice: html("notice"), remedy: html("remedy"), away: html("away"),
    said: html("said"), facts: html("facts"), sent: html("sent"), sentJson: html("sent-json"),
    wanted: html("wanted"), problem: html("problem"),
    interrupted: html("interrupted"), interruptedText: html("interrupted-text"), forget: element("forget", HTMLButtonElement),
    senses: { sound: element("sound", HTMLInputElement), vibration: element("vibration", HTMLInputElement), voice: element("voice", HTMLInputElement) },
    resolution: element("resolution", HTMLSelectElement), resolutions: html("resolutions"), goOn: element("go-on", HTMLButtonElement), practice: html("practice"),
    models: [element("model", HTMLButtonElement), element("model-done", HTMLButtonElement)],
    another: html("another"), anothers: /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll(".another")),
    boardLinks: /** @type {NodeListOf<HTMLAnchorElement>} */ (document.querySelectorAll('a[href="../board/"]')),
    camera: element("camera", HTMLSelectElement),
    start: element("start", HTMLButtonElement), startVirtual: element("start-virtual", HTMLButtonElement),
    cancel: element("cancel", HTMLButtonElement), again: element("again", HTMLButtonElement),
    other: element("other", HTMLButtonElement), failedVirtual: element("failed-virtual", HTMLButtonElement),
    loading: element("loading", HTMLProgressElement), openingText: html("opening-text"), failure: html("failure"), kept: html("kept"),
    loadingMeter: html("loading-meter"),
    controls: html("controls"), progress: element("progress", HTMLProgressElement), counts: html("counts"),
    undo: element("undo", HTMLButtonElement), skip: element("skip", HTMLButtonElement), stop: element("stop", HTMLButtonElement),
    result: html("result"),
  };
}

/** @typedef {ReturnType<typeof findParts>} Parts */

/** @param {Parts} parts @param {State} state @param {State | null} before what the page shows */
export function render(parts, state, before) {
  const { phase } = state;
  if (phase !== before?.phase) {
    for (const [name, sheet] of Object.entries(parts.sheets)) sheet.hidden = name !== phase;
    parts.reticle.hidden = parts.controls.hidden = phase !== "capturing";
    // Dark where one looks, light where one reads.
    document.body.classList.toggle("viewfinder", phase !== "done");
    // What had the focus is gone: go on where the page goes on. Not when it is first shown.
    if (before) focus(parts, phase);
    if (phase === "failed") renderFailure(parts, state);
  }
  if (state.cameras !== before?.cameras) renderCameras(parts, state);
  if (state.interrupted !== before?.interrupted) {
    parts.interrupted.hidden = state.interrupted === null;
    text(parts.interruptedText, words.interrupted(state));
    renderChoice(parts);
  }
  if (state.key !== before?.key || state.request !== before?.request || state.cropped !== before?.cropped) renderCamera(parts, state);
  parts.loading.value = state.loading;
  parts.stage.classList.toggle("plain", state.plain || (state.pose !== null && state.picture === null));
  if (phase === "opening") renderOpening(parts, state);
  renderTarget(parts, state, before);
  if (phase === "capturing") renderCapture(parts, state, before);
  if (state.session !== before?.session || state.progress !== before?.progress || state.stored !== before?.stored
    || state.away !== before?.away) renderProgress(parts, state);
}

/** @param {Parts} parts @param {State["phase"]} phase */
function focus({ instruction, sheets }, phase) {
  if (phase === "capturing") instruction.focus();
  else sheets[phase].querySelector("h1")?.focus();
}

/** @param {Parts} parts @param {State} state */
function renderOpening({ openingText, loadingMeter }, state) {
  loadingMeter.hidden = state.waiting !== "detector";
  text(openingText, words.opening(state));
}

/** @param {Parts} parts @param {State} state */
function renderFailure({ failure, kept, failedVirtual }, state) {
  text(failure, words.failure(state));
  text(kept, words.kept(state));
  kept.hidden = words.kept(state) === "";
  failedVirtual.hidden = state.failure?.code !== "not_found";
}

/** @param {Parts} parts @param {State} state */
function renderCameras(parts, state) {
  const { camera, wanted } = parts;
  const proposed = propose(state.cameras, state.wanted.camera ?? state.interrupted?.camera ?? null, camera.value);
  camera.replaceChildren(...state.cameras.map((choice) => new Option(words.named(choice), choice.id)));
  // Before the browser has said which there are, nothing is said of them.
  if (proposed === "" && state.cameras.length > 0 && state.cameras.every(({ id }) => id !== "")) camera.prepend(new Option(t("capture.no_camera"), ""));
  camera.value = proposed;
  renderChoice(parts);
  text(wanted, words.wanted(state));
  wanted.hidden = words.wanted(state) === "";
}

/** What can be done with the camera chosen: a made-up one has one size, none cannot be opened, and what was interrupted comes first. @param {Parts} parts */
export function renderChoice({ camera, resolutions, start, startVirtual, interrupted }) {
  resolutions.hidden = camera.value === "virtual";
  const none = camera.selectedOptions[0]?.text === t("capture.no_camera");
  start.classList.toggle("primary", !none && interrupted.hidden === true);
  startVirtual.classList.toggle("primary", none && interrupted.hidden === true);
}

/** @param {Parts} parts @param {State} state */
function renderCamera({ practice, stage, marks, pictureEdge, facts, sent, sentJson, anothers }, state) {
  const { key, mirrored } = state;
  for (const place of anothers) {
    text(place, words.another(state));
    place.hidden = words.another(state) === "";
  }
  stage.classList.toggle("mirrored", mirrored);
  sent.hidden = !key;
  text(facts, words.facts(state));
  text(sentJson, words.sent(state));
  practice.hidden = !isVirtual(key?.camera ?? "");
  if (!key) return;
  marks.setAttribute("viewBox", `-0.5 -0.5 ${key.img_size.join(" ")}`);
  pictureEdge.setAttribute("width", String(key.img_size[0]));
  pictureEdge.setAttribute("height", String(key.img_size[1]));
}

/** @param {Parts} parts @param {State} state @param {State | null} before */
function renderCapture(parts, state, before) {
  renderSeen(parts, state, before);
  const held = Math.round(100 * holdProgress(state));
  parts.held.setAttribute("stroke-dasharray", `${held} 100`);
  // The ring stands for the last view until another one is held, or on its way.
  const free = requiredHold(state) === null && !(state.busy && state.pose);
  const taken = free && state.notice?.kind === "good" && state.notice.key.startsWith("capture.view_");
  parts.ring.toggleAttribute("hidden", held === 0 && !taken);
  parts.ring.classList.toggle("taken", held === 0 && taken);
  text(parts.instruction, words.instruction(state));
  show(parts.remedy, words.remedy(state));
  show(parts.away, words.standing(state));
  show(parts.notice, words.notice(state.notice));
  for (const kind of ["bad", "plain"]) parts.notice.classList.toggle(kind, state.notice?.kind === kind);
  text(parts.stop, words.stopping(state));
}

/** @param {HTMLElement} where @param {string} words hidden where there are none */
function show(where, words) {
  text(where, words);
  where.hidden = words === "";
}

/** @param {Parts} parts @param {State} state */
function renderProgress(parts, state) {
  parts.progress.value = state.progress;
  for (const button of parts.models) show(button, words.withModel(state));
  text(parts.counts, words.counts(state));
  // Not while busy: a button that is disabled under the finger loses the keyboard's focus.
  const none = viewCount(state) === 0;
  show(parts.another, words.warning(state));
  if (none && document.activeElement === parts.undo) parts.instruction.focus();
  parts.undo.disabled = none;
}

/** Writes only what changed: a live region speaks on every write. @param {Element} where @param {string} words */
function text(where, words) {
  if (where.textContent !== words) where.textContent = words;
}
