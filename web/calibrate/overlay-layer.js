// Overlay on the video: the target and its preview, the detected corners, the arrows.
import { drawArrows, drawBoard, drawTarget, visibleShare } from "../lib/capture/marks.js";
import { arrows } from "./hint-arrows.js";
import { viewCount } from "./state.js";
import { unmirrored } from "./status-text.js";

/** @typedef {import("./state.js").State} State */
/** @typedef {import("./parts.js").Parts} Parts */

const LATER_VISIBILITY = 0.6; // once a view was taken: the visitor then knows what a target is
const [MIN_FILL, MAX_FILL] = [0.04, 0.16]; // opacity of the target's area

/** @param {Parts} parts @param {State} state @param {State | null} before */
export function renderTarget(parts, state, before) {
  const {
    sight: { target },
    ui: { picture },
  } = state;
  if (picture !== before?.ui.picture) {
    const { overlay } = parts;
    overlay.hidden = !picture;
    if (picture) overlay.src = picture;
  }
  if (target !== before?.sight.target) drawTarget(parts, state.board, target);
}

/**
 * Fades the target as the board approaches: where both overlap, only the outline distinguishes them.
 * @param {Parts} parts @param {State} state @param {State | null} before
 */
function fadeTarget({ overlay, target, ghost }, state, before) {
  const shown = visibility(state);
  if (before && before.phase === "capturing" && shown === visibility(before)) return;
  overlay.style.opacity = ghost.style.opacity = String(shown);
  overlay.style.visibility = shown > 0 ? "" : "hidden";
  target.style.fillOpacity = String(MIN_FILL + (MAX_FILL - MIN_FILL) * shown);
}

/** Share of the target's squares that is shown, 0…1 in steps that are not worth more drawing. @param {State} state */
export function visibility(state) {
  const most = viewCount(state) === 0 ? 1 : LATER_VISIBILITY;
  return Math.round(most * visibleShare(state.sight.overlap) * 20) / 20;
}

/** @param {Parts} parts @param {State} state @param {State | null} before */
export function renderDetection(parts, state, before) {
  fadeTarget(parts, state, before);
  const { sight, ui } = state;
  if (sight.corners === before?.sight.corners && ui.instruction === before?.ui.instruction) return;
  drawBoard(parts, sight);
  drawArrows(parts.arrows, arrows(unmirrored(state), sight.outline, sight.aim, sight.size[0]));
}
