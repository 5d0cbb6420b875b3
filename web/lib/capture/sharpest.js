// The sharpest frames of a board that is never held still: one of each place, to be used as photographs. Pure.
import { rankByNovelty } from "../rank.js";
import { motion } from "./stillness.js";

/** @typedef {import("../board-outline.js").Corners & {outline: [number, number][] | null, sharpness: number}} Frame */

const APART_WIDTHS = 0.04; // of the picture: nearer frames are of one place
const MAX_PLACES = 40;
const MIN_CORNERS = 6;

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

  /** Those that say most together. @param {number} count @param {[number, number]} size of the picture, px */
  best(count, size) {
    return rankByNovelty(this.#frames, size, count).map(({ ids, points }) => ({ ids, points }));
  }
}
