// Rules for taking a view automatically: is the board at the target, is it held still there, for how long? Pure.
import { foreshortening } from "../lib/board-outline.js";
import { isExhausted, viewCount } from "./state.js";
import { HOLD_MS, LONG_HOLD_MS, MIN_DISPLACEMENT_PX, isAtTarget, lenienceAfter } from "../lib/capture/target.js";
import { motion } from "../lib/capture/stillness.js";

/**
 * @typedef {import("./state.js").State} State
 *
 * @typedef {import("../lib/board-outline.js").Corners} Corners
 */

export { HOLD_MS, LONG_HOLD_MS };
const MIN_FORESHORTENING = 0.08; // from which a pose other than the target may be worth sending
const MIN_HOLD_FRAMES = 3; // so that a stalled video does not count as a steady hand
const STUCK_MS = 15_000; // without coming nearer to the target, then another kind of pose is requested
const MAX_TARGET_MS = 45_000; // after which one is requested in any case
const READ_REFUSAL_MS = 3_000; // after a refusal at the target: time to read the reason
const READ_USELESS_MS = 1_000; // after a refusal that nothing can be done about
const SETTLED_MS = 300; // of holding still before the camera's focus is locked: less than a view takes
const MIN_VISIBLE_SHARE = 0.6; // of the board's corners from which the lens is taken to be focused on it

/** True if the board is at the target, and tilted as the target is. @param {State} state */
export function isThere({ capture: { aim }, detector }) {
  return isAtTarget(detector, aim);
}

/**
 * Time for which the board must be held still where it is now, ms; null: no view will be taken there.
 * @param {State} state
 */
export function requiredHold(state) {
  const {
    capture: { key, pose, lastHold, taken },
    detector: { outline },
  } = state;
  if (!key || !pose || !outline || isNear(state, lastHold)) return null;
  if (isThere(state)) return HOLD_MS;
  if (taken.some((hold) => isNear(state, hold))) return null;
  return foreshortening(outline) > MIN_FORESHORTENING ? LONG_HOLD_MS : null;
}

/** True if the board is where it was held then. @param {State} state @param {Corners | null} hold */
function isNear({ capture: { key }, detector: { corners } }, hold) {
  return hold !== null && key !== null && motion(hold, corners) < (MIN_DISPLACEMENT_PX * key.img_size[0]) / 1280;
}

/**
 * True if the board has just been held again where a view was taken before.
 * @param {number} held ms, before the last frame
 * @param {State} state
 */
export function isRepeat(held, state) {
  const { lastHold, lastRepeat, pose, taken } = state.capture;
  const { stillness } = state.detector;
  if (!pose || state.link.busy || held >= HOLD_MS || stillness.held < HOLD_MS) return false;
  if (isThere(state) || isNear(state, lastRepeat ?? lastHold)) return false;
  return taken.some((hold) => isNear(state, hold));
}

/** Progress of the hold, 0…1. @param {State} state */
export function holdProgress(state) {
  const required = requiredHold(state);
  return required === null || state.link.busy ? 0 : Math.min(1, state.detector.stillness.held / required);
}

/**
 * Factor on the motion that counts as still: it grows with time, for visitors without a steady hand.
 * @param {State} state @param {number} time ms
 */
export function lenience({ capture: { posedAt } }, time) {
  return lenienceAfter(time - posedAt);
}

/**
 * True if the board is held before the camera and is in focus, so that the focus may be locked.
 * @param {State} state
 */
export function isSettled({
  board: {
    squares: [columns, rows],
  },
  detector: { corners, diagnosis, stillness },
}) {
  return (
    diagnosis.suspected === null &&
    stillness.held >= SETTLED_MS &&
    corners.ids.length >= MIN_VISIBLE_SHARE * (columns - 1) * (rows - 1)
  );
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
  const { phase, capture, link, detector, ui } = state;
  if (phase !== "capturing" || link.busy || !capture.pose) return null;
  const required = requiredHold(state);
  const { held, frames } = detector.stillness;
  if (required !== null && held >= required && frames >= MIN_HOLD_FRAMES) return "submit";
  if (detector.diagnosis.trouble === "legacy" && viewCount(state) === 0) return "relayout";
  if (isExhausted(state, time)) return "finish";
  // While no board is in sight, another pose would not help.
  if (detector.corners.ids.length === 0) return null;
  if (capture.skipAfter !== null) return time - ui.noticedAt > capture.skipAfter ? "skip" : null;
  return time - capture.nearest.time > STUCK_MS || time - capture.posedAt > MAX_TARGET_MS ? "skip" : null;
}
