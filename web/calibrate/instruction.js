// One short instruction at a time, the most important first, and none that flickers.
import { advice } from "./target.js";

/**
 * @typedef {object} Instruction
 * @property {string} text what is shown
 * @property {string} next what would be shown
 * @property {number} since ms, when `next` was first wanted
 */

/** @type {Instruction} */
export const SILENT = { text: "", next: "", since: 0 };

const STEADY = 400; // ms that a new instruction must be wanted for

/**
 * @param {import("./state.js").State} state @param {boolean} holding would this be taken if it were held still?
 * @param {number} time ms
 * @returns {Instruction}
 */
export function instruct(state, holding, time) {
  const wanted = choose(state, holding);
  const { text, next, since } = state.instruction;
  if (wanted !== next) return { text: text || wanted, next: wanted, since: time };
  return time - since >= STEADY ? { text: wanted, next, since } : state.instruction;
}

/** @param {import("./state.js").State} state @param {boolean} holding */
function choose({ pose, corners, markers, outline, aim, mirrored }, holding) {
  if (!pose) return "Good. Wait a moment";
  if (corners.ids.length === 0) return markers > 0 ? "Closer, or a little slower" : "Show the board to the camera";
  if (!outline) return "Show more of the board";
  if (holding) return "Hold still";
  const words = aim ? advice(outline, aim) || "Match the outline" : pose.hint;
  return mirrored ? asMirrored(words) : words;
}

/** @type {Record<string, string>} */
const OTHER_SIDE = { left: "right", right: "left", Left: "Right", Right: "Left" };

/**
 * Directions as they look in a mirror: what is said must agree with the preview, and hints speak of the camera's picture.
 * @param {string} words
 */
export function asMirrored(words) {
  return words.replace(/\b(left|right)\b/gi, (side) => OTHER_SIDE[side] ?? side);
}
