// Search for unknown boards in one picture. The conclusion from several pictures is board-recognition.js.
import { FAMILIES, isTagFamily, isTelling } from "./board-recognition.js";
import { negative } from "./charuco-finder.js";
import { recogniseChessboard, shrunk } from "./chessboard.js";
import { MarkerDetector } from "./marker-detector.js";

/**
 * @typedef {import("./subpixel.js").Grey} Grey
 * @typedef {import("./board-recognition.js").Sighting} Sighting
 * @typedef {{families?: string[], inverted?: boolean}} Hints families: of markers to look for first, as an earlier picture showed
 *   them; inverted: look for white markers, too
 */

const MAX_SIDE_PX = 1500; // of a picture in which markers are looked for: a print-out fills a good part of it
const KALIBR_BORDER = 2; // cells; looked for first: within a wide border lies a narrow one

export class Recogniser {
  #cv;
  /** @type {Map<string, MarkerDetector>} */
  #detectors = new Map();

  /** @param {any} cv OpenCV's module */
  constructor(cv) {
    this.#cv = cv;
  }

  /** @param {Grey} image @param {Hints} hints @returns {Sighting} */
  look(image, { families = [], inverted = false }) {
    const factor = Math.max(1, Math.ceil(Math.max(image.width, image.height) / MAX_SIDE_PX));
    const small = shrunk(image, factor);
    /** @type {[number, number]} */
    const size = [image.width, image.height];
    const chessboard = recogniseChessboard(image);
    const nothing = { family: null, markers: [], inverted: false, size, chessboard };
    if (chessboard?.isPlain) return nothing;
    for (const isInverted of inverted ? [false, true] : [false]) {
      const upright = isInverted ? negative(small) : small;
      for (const family of new Set([...families, ...FAMILIES])) {
        for (const border of isTagFamily(family) ? [KALIBR_BORDER, 1] : [1]) {
          const markers = this.#detector(family, border).find(upright).map(({ id, corners }) =>
            ({ id, corners: corners.map(([x, y]) => [factor * (x + 0.5) - 0.5, factor * (y + 0.5) - 0.5]) }));
          /** @type {Sighting} */
          const sighting = { ...nothing, family, markers, inverted: isInverted };
          if (isTelling(sighting)) return sighting;
        }
      }
    }
    return nothing;
  }

  /** @param {string} family @param {number} border */
  #detector(family, border) {
    const name = `${family} ${border}`;
    const detector = this.#detectors.get(name) ?? new MarkerDetector(this.#cv, family, { border, refined: true });
    this.#detectors.set(name, detector);
    return detector;
  }
}
