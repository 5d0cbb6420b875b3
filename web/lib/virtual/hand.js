// Simulated hand: the board's motion to a target, and its tremor there. Pure: the time is an argument.
import { interpolatePose, perturbPose, seededRandom, transformPoint } from "../pose.js";

/** @import { Pose } from "../pose.js" */

/**
 * @typedef {object} Kind
 * @property {number} travel ms from one pose to the next
 * @property {number} tremor px at 1280 px image width, amplitude of a fast tremor, as the camera sees it
 * @property {number} sway px, amplitude of a slow one
 * @property {number} blurred share of the frames that motion blurs
 */

/** @type {Record<string, Kind>} */
export const HANDS = {
  quick: { travel: 100, tremor: 0, sway: 0, blurred: 0 },
  still: { travel: 500, tremor: 0, sway: 0, blurred: 0 },
  person: { travel: 1_200, tremor: 0.5, sway: 1, blurred: 0.1 },
  shaky: { travel: 1_200, tremor: 2.5, sway: 4, blurred: 0.2 },
  slow: { travel: 7_000, tremor: 0.5, sway: 1, blurred: 0.1 },
};

const TREMOR_HZ = 8.3; // Hz: physiological tremor has 8 to 12
const SWAY_HZ = 0.7; // Hz

export class Hand {
  #kind;
  #error;
  #random;
  /** A separate generator, so that the hand's path does not depend on the number of painted frames. */
  #randomBlur;
  #pivot;
  #focal;
  /** @type {Pose} */
  #from;
  /** @type {Pose} */
  #to;
  #started = -Infinity;
  #phases;

  /**
   * @param {string} kind of `HANDS`
   * @param {{error: number, seed: number, pivot: number[], focal: number, start: Pose}} options
   *   error: how far it misses, 1 for about 3° and 3 % of the distance; pivot: the board's centre; focal: of the lens,
   * px at 1280 px image width
   */
  constructor(kind, { error, seed, pivot, focal, start }) {
    this.#kind = HANDS[kind] ?? HANDS.still;
    this.#error = error;
    this.#random = seededRandom(seed);
    this.#randomBlur = seededRandom(seed + 1);
    this.#pivot = pivot;
    this.#focal = focal;
    this.#from = this.#to = start;
    this.#phases = Array.from({ length: 6 }, () => 2 * Math.PI * this.#random());
  }

  /** @param {Pose} target board → camera, squares @param {number} time ms */
  follow(target, time) {
    this.#from = this.#way(time);
    this.#to = this.#error > 0 ? perturbPose(target, this.#error, this.#random, this.#pivot) : target;
    this.#started = time;
  }

  /** @param {number} time ms @returns {Pose} */
  pose(time) {
    return this.#trembling(this.#way(time), time);
  }

  /** True if the picture changes at this time. @param {number} time ms */
  moves(time) {
    const { travel, tremor, sway } = this.#kind;
    return tremor > 0 || sway > 0 || time - this.#started < travel;
  }

  /** The blur of one frame, px; 0 for none. */
  blur() {
    return this.#randomBlur() < this.#kind.blurred ? Math.round(7 + 8 * this.#randomBlur()) : 0;
  }

  /** @param {number} time */
  #way(time) {
    const part = Math.min(1, (time - this.#started) / this.#kind.travel);
    // Slow at both ends, as hands are.
    return interpolatePose(this.#from, this.#to, part * part * (3 - 2 * part));
  }

  /** @param {Pose} pose @param {number} time */
  #trembling({ rvec, tvec }, time) {
    const { tremor, sway } = this.#kind;
    if (tremor === 0 && sway === 0) return { rvec, tvec };
    const wave = (/** @type {number} */ index, /** @type {number} */ hertz) =>
      Math.sin((2 * Math.PI * hertz * time) / 1000 + this.#phases[index]);
    // One pixel at the board's distance, in squares.
    const pixel = transformPoint({ rvec, tvec }, this.#pivot)[2] / this.#focal;
    const shift = [0, 1].map(
      (axis) => pixel * (tremor * wave(axis, TREMOR_HZ + axis) + sway * wave(2 + axis, SWAY_HZ + 0.2 * axis)),
    );
    const turn = (tremor * wave(4, TREMOR_HZ - 1) + sway * wave(5, SWAY_HZ)) / this.#focal;
    return { rvec: [rvec[0] + turn, rvec[1] - turn, rvec[2]], tvec: [tvec[0] + shift[0], tvec[1] + shift[1], tvec[2]] };
  }
}
