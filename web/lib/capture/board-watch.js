// Watch for another board than the one expected, while that one is not seen: a look from time to time, and a
// conclusion from several. Pure: the time comes in.
import { isPartOf, recognise } from "../board-recognition.js";
import { isSameBoard } from "../board.js";

/** @import { Recognised, Sighting } from "../board-recognition.js" */

/**
 * @typedef {import("../board.js").SentBoard} Board
 */

const BLIND_MS = 300; // without a corner, before anything else is looked for
const BETWEEN_MS = 300; // between looks: each takes as long as some frames
const MAX_SIGHTINGS = 8; // the newest ones count
const MIN_SUPPORT = 2; // sightings that agree: one may be an accident

export class BoardWatch {
  /** @type {Sighting[]} */
  #sightings = [];
  #lookedAt = -Infinity;

  /**
   * True if the next frame is to be looked at.
   * @param {number} blindSince ms, since when no corner is seen; infinite while some are
   * @param {number} time ms
   */
  isDue(blindSince, time) {
    if (blindSince === Infinity) this.#sightings = [];
    return time - blindSince >= BLIND_MS && time - this.#lookedAt >= BETWEEN_MS;
  }

  /**
   * @param {Sighting} sighting @param {Board} expected @param {number} time ms, when it was there
   * @returns {Recognised | null} what is there instead of the expected board
   */
  add(sighting, expected, time) {
    this.#lookedAt = time;
    this.#sightings = [...this.#sightings, sighting].slice(-MAX_SIGHTINGS);
    const found = recognise(this.#sightings);
    if (!found || found.support < MIN_SUPPORT) return null;
    const isExpected = isSameBoard(found.board, expected) || isPartOf(found.board, expected);
    return isExpected && !found.mirrored ? null : found;
  }
}
