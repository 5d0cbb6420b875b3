// Overlay on the video: the target and its preview, the detected corners, the arrows.
import { drawArrows, drawBoard, drawTarget, visibleShare } from "../lib/capture/marks.js";
import { viewCount } from "./state.js";
import { unmirrored } from "./status-text.js";
import { middle, upright } from "../lib/capture/target.js";

/**
 * @import { Parts } from "./parts.js"
 * @import { State } from "./state.js"
 */

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

/** @typedef {[x1: number, y1: number, x2: number, y2: number]} Arrow */

const MIN_LENGTH_PX = 14; // at 1280 px image width
const EDGES = ["tilt_top", "tilt_right", "tilt_bottom", "tilt_left"];

/**
 * Arrows that illustrate an instruction, from the board to its target, in pixels of the camera's image.
 * @param {string} code of the instruction, about the camera's picture
 * @param {number[][] | null} outline of the board as seen @param {number[][] | null} aim of the target
 * @param {number} width of the image, px
 * @returns {Arrow[]} one between the centres to move the board; from its corners to turn it, tilt it or change its
 *   distance
 */
export function arrows(code, outline, aim, width) {
  if (!outline || !aim) return [];
  const seen = upright(outline, aim);
  if (/^(up|down|left|right)/.test(code)) return withoutShort([[...middle(seen), ...middle(aim)]], width);
  const ways = seen.map((from, index) => [...from, ...aim[index]]);
  if (code === "closer" || code === "farther" || code.startsWith("turn_")) return withoutShort(ways, width);
  const side = EDGES.indexOf(code);
  if (side < 0) return [];
  // The edge as it lies in the image: the board may be upside down.
  const value = (/** @type {number[]} */ [x, y]) => [-y, x, y, -x][side];
  const [a, b] = [0, 1, 2, 3].sort((i, j) => value(aim[j]) - value(aim[i]));
  return withoutShort([ways[a], ways[b]], width);
}

/** @param {number[][]} ways @param {number} width @returns {Arrow[]} */
function withoutShort(ways, width) {
  const shortest = (MIN_LENGTH_PX * width) / 1280;
  return /** @type {Arrow[]} */ (ways.filter(([x1, y1, x2, y2]) => Math.hypot(x2 - x1, y2 - y1) > shortest));
}
