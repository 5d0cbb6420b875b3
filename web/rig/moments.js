// Rules of a moment: when it is opened, and whether a camera may take a view for it. Pure: the time comes in.
//
// Cameras have no common clock. A moment was opened at some time between the last answer without it and the first one
// with it. A camera takes a view only if the board has been still in its own picture since before that answer was
// requested: then the board was still in all cameras that take one when the moment was opened, and all saw the same
// pose.
import { observedOutline } from "../lib/board-outline.js";
import { HOLD_MS, LONG_HOLD_MS, MIN_DISPLACEMENT_PX, isAtTarget, difference } from "../lib/capture/target.js";
import { HEALTHY, diagnose } from "../lib/capture/diagnosis.js";
import { jaccard } from "../lib/capture/jaccard.js";
import { MOVING, motion, observe } from "../lib/capture/stillness.js";

/**
 * @typedef {import("../lib/board-outline.js").Corners} Corners
 * @typedef {import("../lib/detector.js").Detection} Detection
 * @typedef {import("./service.js").Target} Target
 *
 * @typedef {object} Sight of the board in one camera
 * @property {Corners} corners of the last frame
 * @property {number} markers
 * @property {[number, number][] | null} outline px
 * @property {import("../lib/capture/stillness.js").Stillness} stillness
 * @property {import("../lib/capture/diagnosis.js").Diagnosis} diagnosis
 * @property {number} overlap with the target, Jaccard index
 * @property {[number, number][] | null} aim the target's outline; null where too little of it is in the picture
 * @property {Target | null} target
 * @property {number} distance from the target: 0 there, infinite where the two cannot be compared
 * @property {Corners | null} lastTaken corners of the view taken last: the same hold is not taken twice
 * @property {number} width of the picture, px
 */

const REMOTE_HOLD_MS = 1_900; // still, before other devices can have seen that it is: they ask once a second
const MORE_HOLD_MS = 900; // more, after each moment that they have not answered: their network may be slow
const MAX_REMOTE_HOLD_MS = 5_000;
const MIN_HELD_MS = 250; // still in a camera that takes a view
const MIN_HELD_FRAMES = 2;
const ANSWER_MS = 900; // for which a camera of this device may take until its board counts as still
const MIN_SEEN_CORNERS = 6;

/** @type {Sight} */
export const BLIND = {
  corners: { ids: [], points: [] },
  markers: 0,
  outline: null,
  stillness: MOVING,
  diagnosis: HEALTHY,
  overlap: 0,
  aim: null,
  target: null,
  distance: Infinity,
  lastTaken: null,
  width: 1280,
};

/**
 * @param {Sight} before
 * @param {Detection} detection
 * @param {number} time ms
 * @param {import("../lib/board.js").Board} board
 * @param {number} [lenience] how many times a steady hand's motion counts as still
 * @returns {Sight}
 */
export function observeFrame(before, detection, time, board, lenience = 1) {
  const { ids, points, markers, size } = detection;
  const found = { ids, points };
  const stillness = observe(before.stillness, found, time, size[0], lenience);
  // A blurred frame in the middle of a hold is ignored.
  const passed = stillness === before.stillness;
  const corners = passed ? before.corners : found;
  const outline = passed ? before.outline : observedOutline(board, corners);
  return measured(
    {
      ...before,
      corners,
      outline,
      stillness,
      markers: passed ? before.markers : markers,
      width: size[0],
      diagnosis: diagnose(before.diagnosis, detection, motion(before.corners, found), time),
    },
    size,
  );
}

/**
 * Gives a camera its target, or none.
 * @param {Sight} sight
 * @param {Target | null} target
 * @param {import("../lib/board.js").Board} board
 * @param {[number, number]} size px
 * @returns {Sight}
 */
export function aimAt(sight, target, board, size) {
  const aim = target && observedOutline(board, { ids: target.ids, points: target.corners });
  return measured({ ...sight, target, aim }, size);
}

/** @param {Sight} sight @param {[number, number]} size px @returns {Sight} */
function measured(sight, size) {
  const { outline, target, aim } = sight;
  const overlap = outline && target ? jaccard(outline, target.outline, size) : 0;
  const distance = outline && aim ? 1 - overlap + difference(outline, aim) : Infinity;
  return { ...sight, overlap, distance };
}

/** True if a camera sees enough of the board to take a view. @param {Sight} sight */
export const isSeen = ({ corners }) => corners.ids.length >= MIN_SEEN_CORNERS;

/**
 * Time for which the board must be held still before a moment is opened, ms; null: it has not been moved since the
 * last one, or no camera sees it.
 * @param {Sight[]} sights of this device @param {number} patience ms, for which other devices need it to be still, too
 */
export function requiredHold(sights, patience) {
  const seeing = sights.filter(isSeen);
  const moved = seeing.some(
    ({ lastTaken, corners, width }) => !lastTaken || motion(lastTaken, corners) >= (MIN_DISPLACEMENT_PX * width) / 1280,
  );
  if (!moved) return null;
  return Math.max(isThere(sights) ? HOLD_MS : LONG_HOLD_MS, patience);
}

/** True if a camera sees the board at its target. @param {Sight[]} sights */
export const isThere = (sights) =>
  sights.some((sight) => isSeen(sight) && sight.target !== null && isAtTarget(sight, sight.aim));

/** Time for which the board has been still in the camera that sees it best, ms. @param {Sight[]} sights */
export function holdTime(sights) {
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
