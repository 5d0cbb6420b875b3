// Square markers (ArUco, AprilTag) in an image, by OpenCV.js's detector.

/** @import { Grey } from "./subpixel.js" */

/**
 * @typedef {{id: number, corners: number[][]}} Marker corners: px, clockwise from the marker's own upper left
 *
 * @typedef {object} MarkerOptions
 * @property {number} [border] width of the black frame, cells: 1, or 2 as Kalibr prints it
 * @property {number} [window] side of the one window of the adaptive threshold, px; three windows unless given, which
 *   take longer
 */

export class MarkerDetector {
  #cv;
  #detector;
  /** @type {{delete: () => void}[]} */
  #held;

  /** @param {any} cv OpenCV's module @param {string} dictionary @param {MarkerOptions} [options] */
  constructor(cv, dictionary, { border = 1, window = 0 } = {}) {
    this.#cv = cv;
    const [words, parameters] = [cv.getPredefinedDictionary(cv[dictionary]), new cv.aruco_DetectorParameters()];
    const refinement = new cv.aruco_RefineParameters(10, 3, true);
    parameters.markerBorderBits = border;
    if (window) parameters.adaptiveThreshWinSizeMin = parameters.adaptiveThreshWinSizeMax = window;
    this.#detector = new cv.aruco_ArucoDetector(words, parameters, refinement);
    this.#held = [this.#detector, words, parameters, refinement];
  }

  /** @param {Grey} image @returns {Marker[]} one of each id: the largest */
  find(image) {
    /** @type {Map<number, Marker>} */
    const found = new Map();
    this.#detect(image, (corners, ids) => {
      corners.forEach((quad, index) => {
        const marker = { id: ids[index], corners: quad };
        const other = found.get(marker.id);
        if (!other || sideOf(other) < sideOf(marker)) found.set(marker.id, marker);
      });
    });
    return [...found.values()];
  }

  /**
   * Dark quadrilaterals, whether or not they are markers.
   * @param {Grey} image
   * @returns {number[][][]} corners, clockwise, px
   */
  quads(image) {
    return this.#detect(image, (corners, _, rejected) => [...corners, ...rejected]);
  }

  /**
   * @template T
   * @param {Grey} image @param {(corners: number[][][], ids: Int32Array, rejected: number[][][]) => T} use @returns {T}
   */
  #detect({ width, height, data }, use) {
    const cv = this.#cv;
    const [input, corners, ids, rejected] = [
      new cv.Mat(height, width, cv.CV_8UC1),
      new cv.MatVector(),
      new cv.Mat(),
      new cv.MatVector(),
    ];
    try {
      input.data.set(data);
      this.#detector.detectMarkers(input, corners, ids, rejected);
      return use(quadsOf(corners), ids.data32S, quadsOf(rejected));
    } finally {
      for (const each of [input, corners, ids, rejected]) each.delete();
    }
  }

  delete() {
    for (const each of this.#held) each.delete();
  }
}

/** @param {any} vector of 1 x 4 points @returns {number[][][]} */
function quadsOf(vector) {
  return Array.from({ length: vector.size() }, (_, index) => {
    const quad = vector.get(index);
    const corners = [0, 1, 2, 3].map((n) => [quad.data32F[2 * n], quad.data32F[2 * n + 1]]);
    quad.delete();
    return corners;
  });
}

/** Mean length of a marker's sides, px. @param {Marker} marker */
export function sideOf({ corners }) {
  return (
    corners.reduce((sum, [x, y], n) => sum + Math.hypot(corners[(n + 1) % 4][0] - x, corners[(n + 1) % 4][1] - y), 0) /
    4
  );
}

/** @param {Marker} marker @returns {number[]} px */
export function centreOf({ corners: [a, b, c, d] }) {
  // Intersection of the diagonals: the centre in the plane of the marker, too.
  const [p, q] = [
    [c[0] - a[0], c[1] - a[1]],
    [d[0] - b[0], d[1] - b[1]],
  ];
  const determinant = p[0] * q[1] - p[1] * q[0];
  const s = ((b[0] - a[0]) * q[1] - (b[1] - a[1]) * q[0]) / (determinant || 1);
  return [a[0] + s * p[0], a[1] + s * p[1]];
}
