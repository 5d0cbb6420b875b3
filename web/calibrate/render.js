// Rendering of the state into the page. Reads nothing back, decides nothing.
import { offerCameras } from "../lib/camera.js";
import { sayFailure, write } from "../lib/dom.js";
import { joinFacts, t } from "../lib/i18n.js";
import { isVirtual } from "../lib/camera-name.js";
import { holdProgress, requiredHold } from "./guidance.js";
import { renderDetection, renderTarget } from "./overlay-layer.js";
import { isFinishable, viewCount, isSharpestOffered } from "./state.js";
import { factRows, requestText } from "./status-text.js";
import * as statusText from "./status-text.js";

/**
 * @import { Parts } from "./parts.js"
 * @import { State } from "./state.js"
 */

/** @param {Parts} parts @param {State} state @param {State | null} before as the page shows it now */
export function render(parts, state, before) {
  const { phase, capture, link, sight, ui } = state;
  if (phase !== before?.phase) renderPhase(parts, state, before !== null);
  if (ui.cameras !== before?.ui.cameras) renderCameras(parts, state);
  if (ui.interrupted !== before?.ui.interrupted) {
    parts.interrupted.hidden = ui.interrupted === null;
    write(parts.interruptedText, statusText.interrupted(state));
    renderChoice(parts);
  }
  const { key, request, cropped, session, progress } = before?.capture ?? {};
  if (capture.key !== key || capture.request !== request || capture.cropped !== cropped) renderCamera(parts, state);
  parts.stage.classList.toggle("flipped", state.wanted.flipped === true);
  parts.stage.classList.toggle("plain", ui.plain || (sight.target !== null && ui.picture === null));
  if (phase === "opening") renderOpening(parts, state);
  renderTarget(parts, state, before);
  if (phase === "capturing") renderCapture(parts, state, before);
  if (
    capture.session !== session ||
    capture.progress !== progress ||
    link.stored !== before?.link.stored ||
    link.offline !== before?.link.offline
  )
    renderProgress(parts, state);
}

/** @param {Parts} parts @param {State} state @param {boolean} moveFocus not when the page is first shown */
function renderPhase(parts, state, moveFocus) {
  const { phase } = state;
  for (const [name, sheet] of Object.entries(parts.sheets)) sheet.hidden = name !== phase;
  parts.reticle.hidden = parts.controls.hidden = phase !== "capturing";
  // Dark behind the video, light behind text.
  document.body.classList.toggle("viewfinder", phase !== "done");
  // The element that had the focus is hidden now.
  if (moveFocus) focus(parts, phase);
  if (phase === "failed") renderFailure(parts, state);
}

/** @param {Parts} parts @param {State["phase"]} phase */
function focus({ instruction, sheets }, phase) {
  if (phase === "capturing") instruction.focus();
  else sheets[phase].querySelector("h1")?.focus();
}

/** @param {Parts} parts @param {State} state */
function renderOpening({ openingText }, state) {
  write(openingText, statusText.opening(state));
}

/** @param {Parts} parts @param {State} state */
function renderFailure({ failure, kept, failedVirtual }, state) {
  sayFailure(failure, statusText.failure(state));
  show(kept, statusText.saved(state));
  failedVirtual.hidden = state.failure?.code !== "not_found";
}

/** @param {Parts} parts @param {State} state */
function renderCameras(parts, state) {
  const { camera, wanted, sender } = parts;
  const { cameras, interrupted } = state.ui;
  offerCameras(camera, cameras, state.wanted.camera ?? interrupted?.camera ?? null);
  renderChoice(parts);
  write(wanted, statusText.wanted(state, !sender.hidden));
}

/**
 * Offers what can be done with the chosen camera: the virtual one has one size, without one the virtual camera comes
 * first, and an interrupted capture comes before either.
 * @param {Parts} parts
 */
export function renderChoice({ camera, resolutions, resolution, lens, setup, start, startVirtual, interrupted }) {
  resolutions.hidden = camera.value === "virtual";
  const none = camera.selectedOptions[0]?.text === t("capture.no_camera");
  start.classList.toggle("primary", !none && interrupted.hidden === true);
  startVirtual.classList.toggle("primary", none && interrupted.hidden === true);
  const chosen = [camera, ...(resolutions.hidden ? [] : [resolution])].map(
    (select) => select.selectedOptions[0]?.text ?? "",
  );
  write(
    setup,
    joinFacts([
      ...chosen.filter(Boolean),
      `${t("capture.fact_distortion_model")}: ${lens.selectedOptions[0]?.text ?? ""}`,
    ]),
  );
}

/** @param {Parts} parts @param {State} state */
function renderCamera({ practice, stage, marks, pictureEdge, facts, sent, sentJson, sentTable, mismatches }, state) {
  const { key, mirrored, request } = state.capture;
  for (const place of mismatches) show(place, statusText.cameraMismatch(state));
  stage.classList.toggle("mirrored", mirrored);
  sent.hidden = !key;
  write(facts, statusText.cameraFacts(state));
  write(sentJson, requestText(request));
  sentTable.replaceChildren(...(request ? factRows(request) : []));
  practice.hidden = !isVirtual(key?.camera ?? "");
  if (!key) return;
  stage.style.setProperty("--aspect", String(key.img_size[0] / key.img_size[1]));
  stage.classList.toggle("landscape", key.img_size[0] > key.img_size[1]);
  marks.setAttribute("viewBox", `-0.5 -0.5 ${key.img_size.join(" ")}`);
  pictureEdge.setAttribute("width", String(key.img_size[0]));
  pictureEdge.setAttribute("height", String(key.img_size[1]));
}

/** @param {Parts} parts @param {State} state @param {State | null} before */
function renderCapture(parts, state, before) {
  const {
    link,
    sight,
    ui,
    ui: { notice },
  } = state;
  renderDetection(parts, state, before);
  const held = Math.round(100 * holdProgress(state));
  parts.held.setAttribute("stroke-dasharray", `${held} 100`);
  // The ring shows the last view as taken until another one is held, or in flight.
  const free = requiredHold(state) === null && !(link.busy && sight.target);
  const taken = free && notice?.kind === "good" && notice.key.startsWith("capture.view_");
  parts.ring.toggleAttribute("hidden", held === 0 && !taken);
  parts.ring.classList.toggle("taken", held === 0 && taken);
  write(parts.instruction, statusText.instruction(state));
  show(parts.remedy, statusText.remedy(state));
  show(parts.statusLine, statusText.statusLine(state));
  show(parts.notice, statusText.notice(notice));
  parts.noBoard.hidden = !(state.detector.boardless || ui.boardWanted) || viewCount(state) > 0;
  const { suggestion } = state.detector;
  parts.boardChoice.hidden =
    !["wrong_board", "mirrored"].includes(ui.instruction.code) || suggestion === null || viewCount(state) > 0;
  write(parts.useBoard, t(suggestion?.mirrored ? "capture.flip" : "capture.use_this_board"));
  parts.sharpest.hidden = !isSharpestOffered(state);
  parts.rightBoard.hidden = suggestion?.mirrored === true;
  for (const kind of ["bad", "plain"]) parts.notice.classList.toggle(kind, notice?.kind === kind);
  write(parts.stop, statusText.stopLabel(state));
}

/** @param {Parts} parts @param {State} state */
function renderProgress(parts, state) {
  for (const button of parts.models) show(button, statusText.suggestedModel(state));
  const [count, ...more] = statusText.counts(state);
  write(parts.count, count);
  write(parts.countMore, more.map((text) => ` · ${text}`).join(""));
  parts.counts.dataset.taken = String(viewCount(state));
  show(parts.accuracy, statusText.accuracy(state));
  parts.finish.hidden = !isFinishable(state);
  show(parts.another, statusText.mismatchWarning(state));
  // Not while busy: a button that is disabled under the finger loses the keyboard's focus.
  const none = viewCount(state) === 0;
  if (none && document.activeElement === parts.undo) parts.instruction.focus();
  parts.undo.disabled = none;
}

/** Writes a text, and hides an element without one. @param {HTMLElement} place @param {string} text */
function show(place, text) {
  write(place, text);
  place.hidden = text === "";
}
