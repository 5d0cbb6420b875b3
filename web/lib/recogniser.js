// Search for unknown boards in one picture. The conclusion from several pictures is board-recognition.js.
import { isTelling } from "./board-recognition.js";
import { negative } from "./charuco-finder.js";
import { recogniseChessboard, shrunk } from "./chessboard.js";
import { MarkerDetector } from "./marker-detector.js";
import { readMarkers } from "./marker-reader.js";

/**
 * @import { Sighting } from "./board-recognition.js"
 * @import { Grey } from "./subpixel.js"
 */

const MAX_SIDE_PX = 1500; // of a picture in which markers are looked for: a print-out fills a good part of it
const ANY_DICTIONARY = "DICT_4X4_50"; // quadrilaterals are found without one

export class Recogniser {
  #detector;

  /** @param {any} cv OpenCV's module */
  constructor(cv) {
    this.#detector = new MarkerDetector(cv, ANY_DICTIONARY);
  }

  /** @param {Grey} image @returns {Sighting} */
  look(image) {
    const factor = Math.max(1, Math.ceil(Math.max(image.width, image.height) / MAX_SIDE_PX));
    const small = shrunk(image, factor);
    const chessboard = recogniseChessboard(image);
    /** @type {Sighting} */
    const nothing = {
      family: null,
      markers: [],
      inverted: false,
      mirrored: false,
      size: [image.width, image.height],
      chessboard,
    };
    /** @type {Sighting[]} */
    const sightings = [];
    for (const inverted of [false, true]) {
      const upright = inverted ? negative(small) : small;
      for (const { family, mirrored, markers } of readMarkers(upright, this.#detector.quads(upright))) {
        const sighting = {
          ...nothing,
          family,
          mirrored,
          inverted,
          markers: markers.map(({ id, corners }) => ({
            id,
            corners: corners.map(([x, y]) => [factor * (x + 0.5) - 0.5, factor * (y + 0.5) - 0.5]),
          })),
        };
        if (isTelling(sighting)) sightings.push(sighting);
      }
    }
    // What fits a board by chance has fewer markers than the board.
    return sightings.sort((a, b) => b.markers.length - a.markers.length)[0] ?? nothing;
  }
}
