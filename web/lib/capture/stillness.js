// Stillness of the board, from its corners frame by frame. Pure: the time comes in.

/** @import { Corners } from "../board-outline.js" */

const MOTION = 2; // px a frame at 1280 px image width, mean over the corners: the published rule
const DRIFT = 6; // px away from where the hold began: slow movement is movement
const GAP = 150; // ms for which frames may be smeared, or show nothing, before the hold is over
// ms between frames that count as held: what a busy device did not look at, it did not see to be still
const MAX_UNSEEN = 250;
const COMMON = 4; // corners that must be seen in both frames to compare them

/**
 * @typedef {object} Stillness
 * @property {Corners | null} anchor where the hold began
 * @property {Corners | null} last
 * @property {number} since ms, when the hold began
 * @property {number} held ms, as far as frames show it
 * @property {number} seen ms, when it was seen to be still last
 * @property {number} frames in the hold, the first not counted
 */

/** @type {Stillness} */
export const MOVING = { anchor: null, last: null, since: 0, held: 0, seen: -Infinity, frames: 0 };

/**
 * @param {Stillness} before @param {Corners} corners @param {number} time ms @param {number} width of the image, px
 * @param {number} [lenience] how many times a steady hand's motion counts as still
 * @returns {Stillness} `before` itself where this frame says nothing: cameras smear one of ten in a hand that is still
 */
export function observe(before, corners, time, width, lenience = 1) {
  const scale = (lenience * width) / 1280;
  const still =
    before.anchor &&
    before.last &&
    motion(before.last, corners) < MOTION * scale &&
    motion(before.anchor, corners) < DRIFT * scale;
  if (still)
    return {
      ...before,
      last: corners,
      held: before.held + Math.min(time - before.seen, MAX_UNSEEN),
      seen: time,
      frames: before.frames + 1,
    };
  if (before.held > 0 && time - before.seen < GAP) return before;
  return { anchor: corners, last: corners, since: time, held: 0, seen: time, frames: 0 };
}

/** Mean distance of the corners seen in both, px; infinite where too few are. @param {Corners} a @param {Corners} b */
export function motion(a, b) {
  const place = new Map(a.ids.map((id, index) => [id, a.points[index]]));
  let sum = 0;
  let count = 0;
  b.ids.forEach((id, index) => {
    const point = place.get(id);
    if (!point) return;
    sum += Math.hypot(point[0] - b.points[index][0], point[1] - b.points[index][1]);
    count += 1;
  });
  return count < COMMON ? Infinity : sum / count;
}
