// Is the board where it is to be, is it held still there, and what does the page do about it by itself? Pure.
import { foreshortening } from "../lib/board-outline.js";
import { difference } from "./target.js";
import { viewCount } from "../lib/session.js";
import { motion } from "./stillness.js";

/** @typedef {import("./state.js").State} State */

export const HOLD = 700; // ms still in the target's place
export const LONG_HOLD = 1500; // ms still anywhere else: the service judges whether it helps all the same
const OVERLAP = 0.6; // Jaccard index with the target that counts as there,
const DIFFERENCE = 0.08; // where the board also lies as the target does
const TILTED = 0.08; // foreshortening from which a pose other than the target may be worth sending
const FRAMES = 3; // in a hold at least: a video that delivers nothing new is not a steady hand
const NEW_PLACE = 8; // px at 1280 px image width from the hold that was sent last
export const STUCK = 15_000; // ms without coming nearer to the target, then another kind of pose is asked for
const ENDLESS = 45_000; // ms after which one is asked for in any case
const FUTILE = 3_000; // ms after a refusal in the target's place: time to read why
const USELESS = 1_000; // ms after one that nothing can be done about
const SETTLED = 300; // ms for which the board is held before the camera's focus is: less than a view takes
const IN_SIGHT = 0.6; // part of the board's corners from which the lens is taken to be focused on it
const STRAINED = 3_000; // ms in which a steady hand would have been still: then less is asked of it,
const LENIENCE = 4; // at most so many times the motion of a steady one

/** Is the board where the target is, and as it is? @param {State} state */
export function isThere({ overlap, outline, aim }) {
  return overlap > OVERLAP && outline !== null && (aim === null || difference(outline, aim) < DIFFERENCE);
}

/**
 * How long the board must be held still where it is now; null: as long as one likes, it will not be taken.
 * @param {State} state
 */
export function requiredHold(state) {
  const { key, pose, outline, answered: sent, corners } = state;
  if (!key || !pose || !outline) return null;
  if (sent && motion(sent, corners) < (NEW_PLACE * key.img_size[0]) / 1280) return null;
  if (isThere(state)) return HOLD;
  return foreshortening(outline) > TILTED ? LONG_HOLD : null;
}

/** The hold as shown: 0…1. @param {State} state */
export function holdProgress(state) {
  const required = requiredHold(state);
  return required === null || state.busy ? 0 : Math.min(1, state.stillness.held / required);
}

/**
 * How many times a steady hand's motion counts as still: not everybody has one.
 * @param {State} state @param {number} time ms
 */
export function lenience({ posedAt }, time) {
  return Math.min(LENIENCE, Math.max(1, (time - posedAt) / STRAINED));
}

/** Is the board held before the camera, and seen sharply? What is out of focus must not be held there. @param {State} state */
export function isSettled({ board: { squares: [columns, rows] }, corners, diagnosis, stillness }) {
  return diagnosis.suspected === null && stillness.held >= SETTLED && corners.ids.length >= IN_SIGHT * (columns - 1) * (rows - 1);
}

/** Time to read why a view was refused, ms. @param {boolean} useless nothing can be done about it */
export const timeToRead = (useless) => (useless ? USELESS : FUTILE);

/**
 * What the page should do by itself now.
 * @param {State} state @param {number} time ms
 * @returns {"submit" | "skip" | "relayout" | null} relayout: the board shown has the other layout, so that is what it is
 */
export function decide(state, time) {
  if (state.phase !== "capturing" || state.busy || !state.pose) return null;
  const required = requiredHold(state);
  if (required !== null && state.stillness.held >= required && state.stillness.frames >= FRAMES) return "submit";
  if (state.diagnosis.trouble === "legacy" && viewCount(state) === 0) return "relayout";
  // Where no board is in sight, another pose would not help.
  if (state.corners.ids.length === 0) return null;
  if (state.futile !== null) return time - state.noticedAt > state.futile ? "skip" : null;
  return time - state.nearest.time > STUCK || time - state.posedAt > ENDLESS ? "skip" : null;
}
