// Rules of a moment: when it is opened, and whether a camera may take a view for it. Pure: the time comes in.
//
// Cameras have no common clock. A moment was opened at some time between the last answer without it and the first one
// with it. A camera takes a view only if the board has been still in its own picture since before that answer was
// requested: then the board was still in all cameras that take one when the moment was opened, and all saw the same
// pose.
import { isNear, isThere } from "../lib/capture/sight.js";
import { HOLD_MS, LONG_HOLD_MS } from "../lib/capture/target.js";

/** @typedef {import("../lib/capture/sight.js").Sight<import("./service.js").Target>} Sight */

const REMOTE_HOLD_MS = 1_900; // still, before other devices can have seen that it is: they ask once a second
const MORE_HOLD_MS = 900; // more, after each moment that they have not answered: their network may be slow
const MAX_REMOTE_HOLD_MS = 5_000;
const MIN_HELD_MS = 250; // still in a camera that takes a view
const MIN_HELD_FRAMES = 2;
const ANSWER_MS = 900; // for which a camera of this device may take until its board counts as still
const MIN_SEEN_CORNERS = 6;

/** True if a camera sees enough of the board to take a view. @param {Sight} sight */
export const isSeen = ({ corners }) => corners.ids.length >= MIN_SEEN_CORNERS;

/**
 * Time for which the board must be held still before a moment is opened, ms; null: it has not been moved since the
 * last one, or no camera sees it.
 * @param {Sight[]} sights of this device @param {number} patience ms, for which other devices need it to be still, too
 */
export function requiredHold(sights, patience) {
  const seeing = sights.filter(isSeen);
  if (!seeing.some((sight) => !isNear(sight, sight.lastTaken))) return null;
  return Math.max(isAtTarget(sights) ? HOLD_MS : LONG_HOLD_MS, patience);
}

/** True if a camera sees the board at its target. @param {Sight[]} sights */
export const isAtTarget = (sights) => sights.some((sight) => isSeen(sight) && sight.target !== null && isThere(sight));

/** Time for which the board has been still in the camera that sees it best, ms. @param {Sight[]} sights */
function holdTime(sights) {
  const steady = sights.filter((sight) => isSeen(sight) && sight.stillness.frames >= MIN_HELD_FRAMES);
  return Math.max(0, ...steady.map(({ stillness }) => stillness.held));
}

/**
 * Time for which other devices need the board to be still, ms.
 * @param {number} unanswered moments in a row that they have not answered
 */
export const remoteHold = (unanswered) => Math.min(MAX_REMOTE_HOLD_MS, REMOTE_HOLD_MS + unanswered * MORE_HOLD_MS);

/** Share of the hold that is done, 0…1. @param {Sight[]} sights @param {number} patience ms */
export function holdProgress(sights, patience) {
  const required = requiredHold(sights, patience);
  return required === null ? 0 : Math.min(1, holdTime(sights) / required);
}

/** True if the leader opens a moment now. @param {Sight[]} sights of its own cameras @param {number} patience ms */
export function isReady(sights, patience) {
  const required = requiredHold(sights, patience);
  return required !== null && holdTime(sights) >= required;
}

/**
 * Decision of a camera about a moment that is open.
 * @param {Sight} sight
 * @param {{unopenedAt: number, seenAt: number}} moment unopenedAt: ms, when it was certainly not open yet;
 *   seenAt: when it was seen to be open
 * @param {number} time ms
 * @returns {"take" | "wait" | "miss"}
 */
export function answer(sight, { unopenedAt, seenAt }, time) {
  const { since, seen, held: steady, frames } = sight.stillness;
  if (!isSeen(sight) || since > unopenedAt) return "miss";
  if (steady >= MIN_HELD_MS && frames >= MIN_HELD_FRAMES && seen >= seenAt) return "take";
  return time - seenAt > ANSWER_MS ? "miss" : "wait";
}
