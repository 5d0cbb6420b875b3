// Rule for a board that is at its target, and times for which it is to be held still.
import { difference } from "./target.js";

export const HOLD_MS = 700; // still at the target
export const LONG_HOLD_MS = 1_500; // still anywhere else: the service judges whether the view helps all the same
// at 1280 px image width, from the hold that was sent last: the service refuses duplicates within 25.6
export const MIN_DISPLACEMENT_PX = 26;
const MIN_OVERLAP = 0.6; // Jaccard index with the target that counts as there,
const MAX_DIFFERENCE = 0.08; // if the board is also tilted as the target is
const LENIENT_AFTER_MS = 3_000; // in which a steady hand would have been still: then less is asked of it,
const MAX_LENIENCE = 4; // at most so many times the motion of a steady hand

/**
 * True if the board is at its target, and tilted as the target is.
 * @param {{overlap: number, outline: number[][] | null}} seen overlap: Jaccard index with the target
 * @param {number[][] | null} aim outline of the target; null where too little of it is in the image
 */
export function isAtTarget({ overlap, outline }, aim) {
  return overlap > MIN_OVERLAP && outline !== null && (aim === null || difference(outline, aim) < MAX_DIFFERENCE);
}

/**
 * Factor on the motion that counts as still: not everybody has a steady hand.
 * @param {number} elapsed ms since the target was set
 */
export const lenienceAfter = (elapsed) => Math.min(MAX_LENIENCE, Math.max(1, elapsed / LENIENT_AFTER_MS));
