// Finder of one board in images, by its kind.
import { corners, kindOf } from "./board.js";
import { aprilgridCorners, typicalSide } from "./aprilgrid.js";
import { createCharucoFinder, negative } from "./charuco-finder.js";
import { findChessboard } from "./chessboard.js";
import { exposure, sharpness } from "./frame-metrics.js";
import { MarkerDetector } from "./marker-detector.js";
import { median } from "./marker-grid.js";

/**
 * @import { Board } from "./board.js"
 * @import { Finder } from "./charuco-finder.js"
 * @import { Grey } from "./subpixel.js"
 */

const BORDERS = [1, 2]; // cells: AprilTag's own and OpenCV's tags, and those that Kalibr prints
/** px; the squares that join an AprilGrid's tags at their corners are parted from them by a small window only. */
const TRACKING_WINDOW_PX = 5;
const MIN_TAGS = 2;
// of one border, from which the other is not looked for: within a wide border lies a narrow one
const MIN_CERTAIN_TAGS = 4;

/** @param {any} cv OpenCV's module @param {Board} board @returns {Finder} */
export function createFinder(cv, board) {
  const kind = kindOf(board);
  return kind === "charuco"
    ? createCharucoFinder(cv, board)
    : kind === "aprilgrid"
      ? createAprilgridFinder(cv, board)
      : createChessboardFinder(cv, board);
}

/** @param {any} cv @param {Board} board @returns {Finder} */
function createAprilgridFinder(cv, board) {
  const [tracking, whole] = [TRACKING_WINDOW_PX, 0].map((window) =>
    BORDERS.map((border) => new MarkerDetector(cv, board.dictionary, { border, window })),
  );
  /** Border that the board was found with last. @type {number | null} */
  let usual = null;
  return {
    find(image, full) {
      const upright = board.inverted ? negative(image) : image;
      const detectors = full ? whole : tracking;
      let tags = usual === null ? [] : detectors[usual].find(upright);
      if (tags.length < MIN_TAGS) {
        const both = detectors.map((detector) => detector.find(upright));
        const better = both[1].length > both[0].length ? 1 : 0;
        tags = both[better];
        usual = tags.length >= MIN_CERTAIN_TAGS ? better : null;
      }
      const seen = aprilgridCorners(upright, board, tags, !full);
      return { ...seen, markers: tags.length, metrics: metricsOf(image, board, seen.points, typicalSide(tags)) };
    },
    memory: 0,
    delete() {
      for (const detector of [...tracking, ...whole]) detector.delete();
    },
  };
}

/** @param {any} cv @param {Board} board @returns {Finder} */
function createChessboardFinder(cv, board) {
  void cv;
  return {
    find(image, full) {
      const seen = findChessboard(image, board.squares, { inverted: board.inverted, full });
      const sides = seen.points.slice(1).map(([x, y], n) => Math.hypot(x - seen.points[n][0], y - seen.points[n][1]));
      return { ...seen, markers: 0, metrics: metricsOf(image, board, seen.points, sides.length ? median(sides) : 0) };
    },
    memory: 0,
    delete() {},
  };
}

/**
 * @param {Grey} image
 * @param {Board} board
 * @param {number[][]} points
 * @param {number} square px
 * @returns {import("./frame-metrics.js").FrameMetrics}
 */
function metricsOf(image, board, points, square) {
  return {
    ...exposure(image),
    sharpness: sharpness(image, points),
    square,
    share: points.length / corners(board).length,
    moire: null,
  };
}
