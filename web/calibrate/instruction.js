// One short instruction at a time, the largest difference first, and none that flickers.
import { isEnough } from "../lib/session.js";
import { advice } from "./target.js";

/**
 * @typedef {object} Instruction
 * @property {string} code what is shown: a text `capture.say_<code>`
 * @property {string} next what would be shown
 * @property {number} since ms, when `next` was first wanted
 */

/** @type {Instruction} */
export const SILENT = { code: "", next: "", since: 0 };

/** What the service may hint at, where the page cannot see for itself. */
export const HINTS = new Set([
  "closer", "farther", "left", "right", "up", "down", "tilt_top", "tilt_bottom", "tilt_left", "tilt_right",
  "turn_clockwise", "turn_counterclockwise", "first",
]);

const STEADY = 400; // ms that a new instruction must be wanted for

/**
 * @param {import("./state.js").State} state @param {boolean} holding would this be taken if it were held still?
 * @param {number} time ms
 * @returns {Instruction}
 */
export function instruct(state, holding, time) {
  const wanted = choose(state, holding);
  const { code, next, since } = state.instruction;
  if (wanted !== next) return { code: code || wanted, next: wanted, since: time };
  return time - since >= STEADY ? { code: wanted, next, since } : state.instruction;
}

/** @param {import("./state.js").State} state @param {boolean} holding */
function choose(state, holding) {
  const { pose, away, busy, corners, markers, outline, aim, mirrored, diagnosis: { trouble } } = state;
  if (isEnough(state)) return "enough";
  if (!pose || busy) return away ? "away" : "wait"; // what is on its way need not be held any more
  if (trouble) return trouble;
  if (corners.ids.length === 0) return markers > 0 ? "slower" : "show";
  if (!outline) return "more";
  if (holding) return "hold";
  const hint = pose.hint_code && HINTS.has(pose.hint_code) ? pose.hint_code : "match";
  const code = aim ? advice(outline, aim) || "match" : hint;
  return mirrored ? asMirrored(code) : code;
}

/** @type {Record<string, string>} */
const OTHER_SIDE = {
  left: "right", right: "left", clockwise: "counterclockwise", counterclockwise: "clockwise",
};

/**
 * Directions as they look in a mirror: what is said must agree with the preview, and codes speak of the camera's picture.
 * @param {string} code
 */
export function asMirrored(code) {
  return code.split("_").map((part) => OTHER_SIDE[part] ?? part).join("_");
}
