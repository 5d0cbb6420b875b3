// Choice of the one instruction that is shown: the largest difference first, and steady enough to be read.
import { isEnough, viewCount } from "./state.js";
import { movement } from "../lib/capture/sight.js";
import { settled } from "../lib/capture/target.js";

/** @typedef {import("./state.js").Instruction} Instruction */

/** @type {Instruction} */
export const SILENT = { code: "", next: "", since: 0 };

/** Hints of the service that the page has a message for. */
export const HINTS = new Set([
  "closer",
  "farther",
  "left",
  "right",
  "up",
  "down",
  "tilt_top",
  "tilt_bottom",
  "tilt_left",
  "tilt_right",
  "turn_clockwise",
  "turn_counterclockwise",
  "first",
]);

const MIN_LOOKS = 3; // for another board, before the first view: until then the board may be in the picture

/**
 * @param {import("./state.js").State} state
 * @param {boolean} holding whether a view would be taken if the board were held still
 * @param {number} time ms
 * @returns {Instruction}
 */
export function instruct(state, holding, time) {
  return settled(state.ui.instruction, choose(state, holding), time);
}

/** @param {import("./state.js").State} state @param {boolean} holding */
function choose(state, holding) {
  const { mirrored } = state.capture;
  const { offline, busy } = state.link;
  const {
    corners,
    markers,
    outline,
    target,
    diagnosis: { trouble },
  } = state.sight;
  if (isEnough(state)) return "enough";
  if (!target || busy) return offline ? "away" : "wait"; // a view in flight need not be held any more
  if (trouble) return trouble;
  if (corners.ids.length === 0) {
    if (state.detector.looks < MIN_LOOKS && viewCount(state) === 0) return "looking";
    return markers === 0 ? "show" : "slower";
  }
  if (!outline) return "more";
  if (holding) return "hold";
  const hint = target.hint_code && HINTS.has(target.hint_code) ? target.hint_code : "match";
  return movement(state.sight, mirrored, hint);
}
