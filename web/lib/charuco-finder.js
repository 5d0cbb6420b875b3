// Finder of a ChArUco board: OpenCV.js's detectors for one board.
import { frameMetrics } from "./frame-metrics.js";
import { refine } from "./subpixel.js";

/**
 * @import { Board } from "./board.js"
 * @import { Grey } from "./subpixel.js"
 */

/**
 * @typedef {object} Finder
 * @property {(image: Grey, full: boolean) => {ids: number[], points: number[][], markers: number, metrics:
 *   import("./frame-metrics.js").FrameMetrics}} find full: for a view that is kept, with all that the detector can
 *   do; else for tracking
 * @property {number} memory bytes that OpenCV's heap has grown to
 * @property {() => void} delete
 */

/**
 * The detectors for one board, and the memory they share.
 * @param {any} cv OpenCV's module
 * @param {Board} board
 * @returns {Finder}
 */
export function createCharucoFinder(cv, board) {
  const [columns, rows] = board.squares;
  const noIds = new cv.Mat();
  const size = new cv.Size(columns, rows);
  const refinement = new cv.aruco_RefineParameters(10, 3, true);
  /** Corners between two markers, and next to one: the picture or a finger may cut off the other. */
  const [between, next] = [2, 1].map((count) => {
    const parameters = new cv.aruco_CharucoParameters();
    parameters.minMarkers = count;
    return parameters;
  });
  /** @type {{delete: () => void}[]} */
  const held = [noIds, refinement, between, next];

  /**
   * Detectors of corners between two markers, and next to one.
   * @param {boolean} full all window sizes of the adaptive threshold, or the one that serves nearly always
   */
  const makeDetector = (full) => {
    const dictionary = cv.getPredefinedDictionary(cv[board.dictionary]);
    const charuco = new cv.aruco_CharucoBoard(size, 1, board.marker_ratio, dictionary, noIds);
    charuco.setLegacyPattern(board.legacy);
    const parameters = new cv.aruco_DetectorParameters();
    if (!full) {
      parameters.adaptiveThreshWinSizeMin = 13;
      parameters.adaptiveThreshWinSizeMax = 13;
    }
    const pair = [between, next].map((each) => new cv.aruco_CharucoDetector(charuco, each, parameters, refinement));
    parameters.delete();
    held.push(...pair, charuco, dictionary);
    return pair;
  };
  const detectors = { tracking: makeDetector(false), full: makeDetector(true) };
  let input = new cv.Mat();

  /**
   * Detects the board where a corner lies between two of its markers, as chance does not put them.
   * @param {any[]} detectors of `makeDetector` @param {Grey} image
   * @returns {{ids: number[], points: number[][], markers: number, side: number}} side: of the markers, median, px
   */
  const detect = ([sure, loose], image) => {
    if (input.rows !== image.height || input.cols !== image.width) {
      input.delete();
      input = new cv.Mat(image.height, image.width, cv.CV_8UC1);
    }
    input.data.set(image.data);
    // New for every frame: markers that are there already are taken as found, and corners that are there already stay
    // there when none is seen.
    const found = { corners: new cv.Mat(), ids: new cv.Mat() };
    const markers = { corners: new cv.MatVector(), ids: new cv.Mat() };
    try {
      sure.detectBoard(input, found.corners, found.ids, markers.corners, markers.ids);
      if (length(found.ids) > 0) loose.detectBoard(input, found.corners, found.ids, markers.corners, markers.ids);
      const ids = length(found.ids) > 0 ? Array.from(/** @type {Int32Array} */ (found.ids.data32S)) : [];
      const positions = ids.length > 0 ? found.corners.data32F : [];
      const points = ids.map((_, index) => [positions[2 * index], positions[2 * index + 1]]);
      return { ids, points, markers: markers.corners.size(), side: ids.length > 0 ? 0 : markerSide(markers.corners) };
    } finally {
      for (const each of [found.corners, found.ids, markers.corners, markers.ids]) each.delete();
    }
  };

  return {
    /** @param {Grey} image @param {boolean} full */
    find(image, full) {
      const upright = board.inverted ? negative(image) : image;
      const { ids, points, markers, side } = detect(full ? detectors.full : detectors.tracking, upright);
      const seen = full ? refine(upright, { ids, points }, columns - 1) : { ids, points };
      return { ...seen, markers, metrics: frameMetrics(image, board, seen, side) };
    },
    /** Bytes that OpenCV's heap has grown to. */
    get memory() {
      return input.data.buffer.byteLength;
    },
    delete() {
      for (const each of [...held, input]) each.delete();
    },
  };
}

/**
 * Median length of the markers' first sides, px; 0 where there are none.
 * @param {any} corners vector of 1 x 4 points
 */
function markerSide(corners) {
  /** @type {number[]} */
  const sides = [];
  for (let index = 0; index < corners.size(); index++) {
    const marker = corners.get(index);
    const [x1, y1, x2, y2] = marker.data32F;
    sides.push(Math.hypot(x2 - x1, y2 - y1));
    marker.delete();
  }
  return sides.sort((a, b) => a - b)[sides.length >> 1] ?? 0;
}

let swapped = new Uint8Array(0);

/** White for black. @param {Grey} image @returns {Grey} memory that the next call writes over */
export function negative({ width, height, data }) {
  if (swapped.length !== width * height) swapped = new Uint8Array(width * height);
  for (let at = 0; at < swapped.length; at++) swapped[at] = 255 - data[at];
  return { width, height, data: swapped };
}

/** Left for right. @param {Grey} image @returns {Grey} new memory */
export function flipped({ width, height, data }) {
  const mirror = new Uint8Array(width * height);
  for (let y = 0, at = 0; y < height; y++) {
    for (let x = width - 1; x >= 0; x--, at++) mirror[at] = data[y * width + x];
  }
  return { width, height, data: mirror };
}

/** Elements of a vector: 1 x n in OpenCV 5, n x 1 before; an empty one may be 1 x 0. @param {any} mat */
function length(mat) {
  return mat.rows * mat.cols;
}
