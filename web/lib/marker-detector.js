// Square markers (ArUco, AprilTag) in an image, by OpenCV.js's detector.

/**
 * @typedef {import("./subpixel.js").Grey} Grey
 * @typedef {{id: number, corners: number[][]}} Marker corners: px, clockwise from the marker's own upper left
 *
 * @typedef {object} MarkerOptions
 * @property {number} [border] width of the black frame, cells: 1, or 2 as Kalibr prints it
 * @property {boolean} [refined] corners to a fraction of a pixel, of markers with white around them
 * @property {number} [window] side of the one window of the adaptive threshold, px; three windows unless given, which take longer
 */

export class MarkerDetector {
  #cv;
  #detector;
  /** @type {{delete: () => void}[]} */
  #held;

  /** @param {any} cv OpenCV's module @param {string} dictionary @param {MarkerOptions} [options] */
  constructor(cv, dictionary, { border = 1, refined = false, window = 0 } = {}) {
    this.#cv = cv;
    const [words, parameters] = [cv.getPredefinedDictionary(cv[dictionary]), new cv.aruco_DetectorParameters()];
    const refinement = new cv.aruco_RefineParameters(10, 3, true);
    parameters.markerBorderBits = border;
    if (window) parameters.adaptiveThreshWinSizeMin = parameters.adaptiveThreshWinSizeMax = window;
    if (refined) parameters.cornerRefinementMethod = cv.CORNER_REFINE_SUBPIX.value ?? cv.CORNER_REFINE_SUBPIX;
    this.#detector = new cv.aruco_ArucoDetector(words, parameters, refinement);
    this.#held = [this.#detector, words, parameters, refinement];
  }

  /** @param {Grey} image @returns {Marker[]} one of each id: the largest */
  find({ width, height, data }) {
    const cv = this.#cv;
    const [input, corners, ids, rejected] = [new cv.Mat(height, width, cv.CV_8UC1), new cv.MatVector(), new cv.Mat(), new cv.MatVector()];
    try {
      input.data.set(data);
      this.#detector.detectMarkers(input, corners, ids, rejected);
      /** @type {Map<number, Marker>} */
      const found = new Map();
      for (let index = 0; index < corners.size(); index++) {
        const quad = corners.get(index);
        const marker = { id: ids.data32S[index], corners: [0, 1, 2, 3].map((n) => [quad.data32F[2 * n], quad.data32F[2 * n + 1]]) };
        quad.delete();
        const other = found.get(marker.id);
        if (!other || sideOf(other) < sideOf(marker)) found.set(marker.id, marker);
      }
      return [...found.values()];
    } finally {
      for (const each of [input, corners, ids, rejected]) each.delete();
    }
  }

  delete() {
    for (const each of this.#held) each.delete();
  }
}

/** Mean length of a marker's sides, px. @param {Marker} marker */
export function sideOf({ corners }) {
  return corners.reduce((sum, [x, y], n) => sum + Math.hypot(corners[(n + 1) % 4][0] - x, corners[(n + 1) % 4][1] - y), 0) / 4;
}

/** @param {Marker} marker @returns {number[]} px */
export function centreOf({ corners: [a, b, c, d] }) {
  // Intersection of the diagonals: the centre in the plane of the marker, too.
  const [p, q] = [[c[0] - a[0], c[1] - a[1]], [d[0] - b[0], d[1] - b[1]]];
  const determinant = p[0] * q[1] - p[1] * q[0];
  const s = ((b[0] - a[0]) * q[1] - (b[1] - a[1]) * q[0]) / (determinant || 1);
  return [a[0] + s * p[0], a[1] + s * p[1]];
}
