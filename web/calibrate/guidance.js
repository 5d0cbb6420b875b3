// Guidance of a capture, pure: when a view is taken automatically (is the board at the target, is it held still there,
// for how long?), and which one instruction is shown: the largest difference first, and steady enough to be read.
import { foreshortening } from "../lib/board-outline.js";
import { isEnough, isExhausted, viewCount } from "./state.js";
import { isNear, isThere, movement } from "../lib/capture/sight.js";
import { HOLD_MS, LONG_HOLD_MS, settled } from "../lib/capture/target.js";

/** @import { Instruction, State } from "./state.js" */

const MIN_FORESHORTENING = 0.08; // from which a pose other than the target may be worth sending
const MIN_HOLD_FRAMES = 3; // so that a stalled video does not count as a steady hand
const STUCK_MS = 15_000; // without coming nearer to the target, then another kind of pose is requested
const MAX_TARGET_MS = 45_000; // after which one is requested in any case
const READ_REFUSAL_MS = 3_000; // after a refusal at the target: time to read the reason
const READ_USELESS_MS = 1_000; // after a refusal that nothing can be done about

/**
 * Time for which the board must be held still where it is now, ms; null: no view will be taken there.
 * @param {State} state
 */
export function requiredHold({ capture: { taken }, sight }) {
  const { target, outline, lastTaken } = sight;
  if (!target || !outline || isNear(sight, lastTaken)) return null;
  if (isThere(sight)) return HOLD_MS;
  if (taken.some((hold) => isNear(sight, hold))) return null;
  return foreshortening(outline) > MIN_FORESHORTENING ? LONG_HOLD_MS : null;
}

/**
 * True if the board has just been held again where a view was taken before.
 * @param {number} held ms, before the last frame
 * @param {State} state
 */
export function isRepeat(held, { capture: { lastRepeat, taken }, sight, link }) {
  if (!sight.target || link.busy || held >= HOLD_MS || sight.stillness.held < HOLD_MS) return false;
  if (isThere(sight) || isNear(sight, lastRepeat ?? sight.lastTaken)) return false;
  return taken.some((hold) => isNear(sight, hold));
}

/** Progress of the hold, 0…1. @param {State} state */
export function holdProgress(state) {
  const required = requiredHold(state);
  return required === null || state.link.busy ? 0 : Math.min(1, state.sight.stillness.held / required);
}

/** Time to read why a view was refused, ms. @param {boolean} useless nothing can be done about it */
export const timeToRead = (useless) => (useless ? READ_USELESS_MS : READ_REFUSAL_MS);

/**
 * Decides which automatic action of the page is due.
 * @param {State} state @param {number} time ms
 * @returns {"submit" | "skip" | "finish" | "relayout" | null} relayout: continue with the board's other layout, which
 *   the camera sees
 */
export function decide(state, time) {
  const { phase, capture, link, sight, ui } = state;
  if (phase !== "capturing" || link.busy || !sight.target) return null;
  const required = requiredHold(state);
  const { held, frames } = sight.stillness;
  if (required !== null && held >= required && frames >= MIN_HOLD_FRAMES) return "submit";
  if (sight.diagnosis.trouble === "legacy" && viewCount(state) === 0) return "relayout";
  if (isExhausted(state, time)) return "finish";
  // While no board is in sight, another pose would not help.
  if (sight.corners.ids.length === 0) return null;
  if (capture.skipAfter !== null) return time - ui.noticedAt > capture.skipAfter ? "skip" : null;
  return time - capture.nearest.time > STUCK_MS || time - capture.posedAt > MAX_TARGET_MS ? "skip" : null;
}

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
 * @param {State} state
 * @param {boolean} holding whether a view would be taken if the board were held still
 * @param {number} time ms
 * @returns {Instruction}
 */
export function instruct(state, holding, time) {
  return settled(state.ui.instruction, choose(state, holding), time);
}

/** @param {State} state @param {boolean} holding */
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
