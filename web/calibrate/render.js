// Puts the state into the page. Reads nothing back, decides nothing.
import { holdProgress } from "./state.js";
import * as words from "./words.js";
import { propose } from "./camera.js";
import { fileName, numbers, verdict } from "./result.js";

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
    corners: svg("corners"), held: svg("held"), ring: svg("ring"),
    reticle: html("reticle"), instruction: html("instruction"), notice: html("notice"), facts: html("facts"),
    wanted: html("wanted"), problem: html("problem"),
    another: html("another"), anothers: /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll(".another")),
    boardLinks: /** @type {NodeListOf<HTMLAnchorElement>} */ (document.querySelectorAll('a[href="../board/"]')),
    camera: element("camera", HTMLSelectElement),
    start: element("start", HTMLButtonElement), startVirtual: element("start-virtual", HTMLButtonElement),
    cancel: element("cancel", HTMLButtonElement), again: element("again", HTMLButtonElement),
    other: element("other", HTMLButtonElement), failedVirtual: element("failed-virtual", HTMLButtonElement), onceMore: element("once-more", HTMLButtonElement),
    loading: element("loading", HTMLProgressElement), openingText: html("opening-text"), failure: html("failure"), kept: html("kept"),
    loadingMeter: html("loading-meter"),
    controls: html("controls"), progress: element("progress", HTMLProgressElement), counts: html("counts"),
    undo: element("undo", HTMLButtonElement), skip: element("skip", HTMLButtonElement), stop: element("stop", HTMLButtonElement),
    verdict: html("verdict"), sentence: html("verdict-sentence"), caption: html("numbers-caption"),
    numbers: html("numbers"), summary: html("summary"), json: html("json"), download: element("download", HTMLAnchorElement),
  };
}

/** @typedef {ReturnType<typeof findParts>} Parts */

/** @param {Parts} parts @param {State} state @param {State | null} before what the page shows */
export function render(parts, state, before) {
  const { phase } = state;
  if (phase !== before?.phase) {
    for (const [name, sheet] of Object.entries(parts.sheets)) sheet.hidden = name !== phase;
    parts.reticle.hidden = parts.controls.hidden = phase !== "capturing";
    // What had the focus is gone: go on where the page goes on. Not when it is first shown.
    if (before) focus(parts, phase);
    if (phase === "failed") renderFailure(parts, state);
  }
  if (state.cameras !== before?.cameras) renderCameras(parts, state);
  if (state.key !== before?.key || state.cropped !== before?.cropped) renderCamera(parts, state);
  parts.loading.value = state.loading;
  if (phase === "opening") renderOpening(parts, state);
  renderTarget(parts, state, before);
  if (phase === "capturing") renderCapture(parts, state, before);
  if (state.session !== before?.session || state.progress !== before?.progress) renderProgress(parts, state);
  if (phase === "done" && before?.phase !== "done") renderResult(parts, state);
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
  text(failure, state.failure ?? "");
  text(kept, words.kept(state));
  kept.hidden = words.kept(state) === "";
  failedVirtual.hidden = !state.failure?.includes("virtual camera");
}

/** @param {Parts} parts @param {State} state */
function renderCameras({ camera, wanted }, state) {
  const proposed = propose(state.cameras, state.wanted.camera, camera.value);
  camera.replaceChildren(...state.cameras.map(({ id, label }) => new Option(label, id)));
  if (proposed === "" && state.cameras.every(({ id }) => id !== "")) camera.prepend(new Option("No camera found", ""));
  camera.value = proposed;
  text(wanted, words.wanted(state));
  wanted.hidden = words.wanted(state) === "";
}

/** @param {Parts} parts @param {State} state */
function renderCamera({ stage, marks, pictureEdge, facts, anothers }, state) {
  const { key, mirrored, cropped } = state;
  for (const place of anothers) {
    text(place, words.another(state));
    place.hidden = words.another(state) === "";
  }
  stage.classList.toggle("mirrored", mirrored);
  if (!key) return text(facts, "");
  marks.setAttribute("viewBox", `-0.5 -0.5 ${key.img_size.join(" ")}`);
  pictureEdge.setAttribute("width", String(key.img_size[0]));
  pictureEdge.setAttribute("height", String(key.img_size[1]));
  const parts = [key.camera, key.img_size.join(" × ")];
  if (key.zoom) parts.push(`zoom ${key.zoom}`);
  if (cropped) parts.push("cropped by the browser");
  text(facts, parts.join(" · "));
}

/** @param {Parts} parts @param {State} state @param {State | null} before */
function renderTarget({ overlay, target, targetBack, targetCorner }, state, before) {
  if (state.picture !== before?.picture) {
    overlay.hidden = !state.picture;
    if (state.picture) overlay.src = state.picture;
  }
  if (state.pose === before?.pose) return;
  const outline = polygon(state.pose?.outline ?? []);
  target.setAttribute("points", outline);
  targetBack.setAttribute("points", outline);
  // Which way up: the board's first corner has a dot, on the target as on the printed board's marker 0.
  const [x, y] = state.pose?.outline[0] ?? [-99, -99];
  targetCorner.setAttribute("cx", String(x));
  targetCorner.setAttribute("cy", String(y));
}

/** @param {Parts} parts @param {State} state @param {State | null} before */
function renderCapture(parts, state, before) {
  const { corners, notice, patience, instruction } = state;
  if (corners !== before?.corners) dots(parts.corners, corners.points);
  const held = Math.round(100 * holdProgress(state));
  parts.held.setAttribute("stroke-dasharray", `${held} 100`);
  parts.ring.toggleAttribute("hidden", held === 0);
  text(parts.instruction, patience > 0 ? "Connection lost. Trying again" : instruction.text);
  parts.notice.hidden = !notice;
  text(parts.notice, notice?.text ?? "");
  for (const kind of ["bad", "plain"]) parts.notice.classList.toggle(kind, notice?.kind === kind);
  text(parts.stop, words.stopping(state));
}

/** @param {Parts} parts @param {State} state */
function renderProgress(parts, state) {
  parts.progress.value = state.progress;
  text(parts.counts, words.counts(state));
  // Not while busy: a button that is disabled under the finger loses the keyboard's focus.
  const none = !state.session?.views.length;
  // Read by the time the first view is taken; after the last one it is said again.
  text(parts.another, words.another(state));
  parts.another.hidden = !none || words.another(state) === "";
  if (none && document.activeElement === parts.undo) parts.instruction.focus();
  parts.undo.disabled = none;
}

/** @param {Parts} parts @param {State} state */
function renderResult(parts, state) {
  const { session } = state;
  const calibration = session?.calibration;
  if (!session || !calibration) return;
  const { word, sentence } = verdict(calibration);
  text(parts.verdict, word);
  text(parts.sentence, sentence);
  const [width, height] = calibration.img_size;
  text(parts.caption, `${calibration.camera}, ${width} × ${height}, ${calibration.distortion_model}`);
  parts.numbers.replaceChildren(...numbers(calibration).map(([name, value, unit]) => {
    const row = document.createElement("tr");
    row.append(cell("th", name), cell("td", value), cell("td", unit));
    row.children[0].setAttribute("scope", "row");
    row.children[2].className = "unit";
    return row;
  }));
  text(parts.summary, words.summary(state));
  const json = `${JSON.stringify(calibration, null, 2)}\n`;
  text(parts.json, json);
  URL.revokeObjectURL(parts.download.href);
  parts.download.href = URL.createObjectURL(new Blob([json], { type: "application/json" }));
  parts.download.download = fileName(calibration);
}

/** @param {string} name @param {string} content */
function cell(name, content) {
  const made = document.createElement(name);
  made.textContent = content;
  return made;
}

/** Circles are kept and moved: making a hundred elements a frame would cost more than finding the board. @param {SVGElement} group @param {number[][]} points */
function dots(group, points) {
  while (group.children.length < points.length) {
    const dot = document.createElementNS("http://www.w3.org/2000/svg", "circle");
    dot.setAttribute("class", "corner");
    dot.setAttribute("r", "5");
    group.append(dot);
  }
  while (group.children.length > points.length) group.lastElementChild?.remove();
  points.forEach(([x, y], index) => {
    group.children[index].setAttribute("cx", x.toFixed(1));
    group.children[index].setAttribute("cy", y.toFixed(1));
  });
}

/** @param {number[][]} points */
const polygon = (points) => points.map(([x, y]) => `${x.toFixed(1)},${y.toFixed(1)}`).join(" ");

/** Writes only what changed: a live region speaks on every write. @param {Element} where @param {string} words */
function text(where, words) {
  if (where.textContent !== words) where.textContent = words;
}
