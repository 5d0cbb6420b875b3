// Order of photographs: those that show the board in a new place or a new attitude come first. Pure.
import { foreshortening } from "./board-outline.js";
import { motion } from "./capture/stillness.js";

/**
 * @typedef {object} Candidate
 * @property {number[][]} points corners found, px
 * @property {[number, number][] | null} outline of the board, px; null where too little of it is seen to tell
 */

const MIN_APART_WIDTHS = 0.02; // of the picture, between frames: nearer, the service takes them for duplicates
const GRID_COLUMNS = 12; // cells of the picture, across
const SHAPE_WEIGHT = 1.5; // weight of a new shape relative to new places
const MAX_OUTLINE_DISTANCE = 0.4; // of the width: beyond it, outlines count as equally different

/**
 * @template {Candidate} C
 * @param {C[]} candidates @param {[number, number]} size px @param {number} [most] of them
 * @returns {C[]} best first; each is the one that adds most to those before it
 */
export function rankByNovelty(candidates, size, most = Infinity) {
  const left = candidates.map((candidate) => ({ candidate, cells: cells(candidate.points, size) }));
  /** @type {C[]} */
  const chosen = [];
  const seen = new Set();
  while (left.length && chosen.length < most) {
    const scores = left.map(
      ({ candidate, cells: its }) =>
        [...its].filter((cell) => !seen.has(cell)).length / GRID_COLUMNS +
        SHAPE_WEIGHT * novelty(candidate, chosen, size[0]),
    );
    const best = scores.indexOf(Math.max(...scores));
    const [{ candidate, cells: its }] = left.splice(best, 1);
    chosen.push(candidate);
    for (const cell of its) seen.add(cell);
  }
  return chosen;
}

/**
 * Frames of a video with different poses: of those at nearly the same place, the one that moved least.
 * @template {{ids: number[], points: number[][]}} F
 * @param {F[]} frames in the video's order @param {number} width of the picture, px
 */
export function distinct(frames, width) {
  const motions = frames.map((frame, index) =>
    Math.max(...[frames[index - 1], frames[index + 1]].filter(Boolean).map((other) => motion(frame, other))),
  );
  /** @type {F[]} */
  const chosen = [];
  for (const index of [...frames.keys()].sort((a, b) => motions[a] - motions[b])) {
    if (chosen.every((other) => motion(frames[index], other) > MIN_APART_WIDTHS * width)) chosen.push(frames[index]);
  }
  return chosen;
}

/** Cells of the picture that have seen corners. @param {number[][]} points @param {[number, number]} size */
function cells(points, [width, height]) {
  const side = width / GRID_COLUMNS;
  const rows = Math.ceil(height / side);
  return new Set(
    points.map(
      ([x, y]) => Math.min(rows - 1, Math.floor((y + 0.5) / side)) * GRID_COLUMNS + Math.floor((x + 0.5) / side),
    ),
  );
}

/**
 * Difference of a board's pose from all chosen, 0…1; the first is to be a tilted one.
 * @param {Candidate} candidate
 * @param {Candidate[]} chosen
 * @param {number} width
 */
function novelty({ outline }, chosen, width) {
  if (!outline) return 0;
  if (chosen.length === 0) return Math.min(1, foreshortening(outline));
  const distances = chosen.map((other) =>
    other.outline ? distance(outline, other.outline) / width : MAX_OUTLINE_DISTANCE,
  );
  return Math.min(MAX_OUTLINE_DISTANCE, ...distances) / MAX_OUTLINE_DISTANCE;
}

/** Root mean squared distance of the vertices, px. @param {number[][]} a @param {number[][]} b */
function distance(a, b) {
  return Math.sqrt(
    a.reduce((sum, [x, y], index) => sum + (x - b[index][0]) ** 2 + (y - b[index][1]) ** 2, 0) / a.length,
  );
}

/**
 * The frames that were taken, by how much each reduced the error, best first; then the others in their order.
 * @template P
 * @param {P[]} pictures
 * @param {(picture: P) => {accepted: boolean, after: number | null} | undefined} judgementOf
 */
export function sortByGain(pictures, judgementOf) {
  const place = (/** @type {P} */ picture) => {
    const judgement = judgementOf(picture);
    return judgement?.accepted ? -(judgement.after ?? Infinity) : 1;
  };
  return [...pictures].sort((a, b) => (place(a) === place(b) ? 0 : place(a) - place(b)));
}

/** @typedef {import("./board-outline.js").Corners & {outline: [number, number][] | null, sharpness: number}} Frame */

const APART_WIDTHS = 0.04; // of the picture: nearer frames are of one place
const MAX_PLACES = 40;
const MIN_CORNERS = 6;

/** Sharpest frames of a board that is never held still, one of each place, to be used as photographs. */
export class Sharpest {
  /** @type {Frame[]} */
  #frames = [];

  /** @param {Frame} frame @param {number} width of the picture, px */
  add(frame, width) {
    if (frame.ids.length < MIN_CORNERS) return;
    const near = this.#frames.filter((other) => motion(other, frame) < APART_WIDTHS * width);
    if (near.some(({ sharpness }) => sharpness >= frame.sharpness)) return;
    const others = this.#frames.filter((other) => !near.includes(other));
    if (others.length < MAX_PLACES) this.#frames = [...others, frame];
  }

  /** The frames most informative together. @param {number} count @param {[number, number]} size of the picture, px */
  best(count, size) {
    return rankByNovelty(this.#frames, size, count).map(({ ids, points }) => ({ ids, points }));
  }
}
