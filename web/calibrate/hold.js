// Rules for taking a view automatically: is the board at the target, is it held still there, for how long? Pure.
import { foreshortening } from "../lib/board-outline.js";
import { isExhausted, viewCount } from "./state.js";
import { isNear, isThere } from "../lib/capture/sight.js";
import { HOLD_MS, LONG_HOLD_MS, lenienceAfter } from "../lib/capture/target.js";

/** @typedef {import("./state.js").State} State */

export { HOLD_MS, LONG_HOLD_MS };
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

/**
 * Factor on the motion that counts as still: it grows with time, for visitors without a steady hand.
 * @param {State} state @param {number} time ms
 */
export function lenience({ capture: { posedAt } }, time) {
  return lenienceAfter(time - posedAt);
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
