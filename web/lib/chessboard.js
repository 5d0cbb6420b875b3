// Chessboards in an image: OpenCV.js binds neither findChessboardCorners nor cornerSubPix, so their corners are found
// as saddle points that form a lattice, and refined as those of a ChArUco board are. Pure.
import { findLattice } from "./chessboard-lattice.js";
import { median } from "./marker-grid.js";
import { saddlePoints } from "./saddle-points.js";
import { refineCorner } from "./subpixel.js";

/**
 * @import { Lattice } from "./chessboard-lattice.js"
 * @import { Grey } from "./subpixel.js"
 */

// px of the longer side at which corners are looked for: blur hides them at the largest
const WORKING_SIDES_PX = [1400, 700, 350];
// the same of a board whose size is known: where it is seen whole at once, the rest is spared
const FULL_SIDES_PX = [700, 1400, 350];
const TRACKING_SIDES_PX = [700];
const MIN_SIDE_CORNERS = 3; // of a board of unknown size: less is found by chance
const CELL_PLACES = [0.2, 0.35, 0.5, 0.65, 0.8]; // within a square
const MAX_PLAIN_DEVIATION = 0.15; // within a square, of the contrast: with a marker in it it is about 0.5
const MIN_SEEN_SHARE = 0.9; // of the corners of a board that counts as whole
const WINDOW_SHARE = 0.2; // of a square's side: half the window of the refinement
const [MIN_WINDOW_PX, MAX_WINDOW_PX] = [2, 9];
const WIDE_TOLERANCE_PX = 0.2; // of the first refinement, which the second one follows

/**
 * Chessboard of known size, whole in the picture.
 * @param {Grey} image @param {[number, number]} squares columns and rows of the board
 * @param {{inverted?: boolean, full?: boolean}} [options] inverted: its first square is white; full: all sizes of
 *   corners, else the usual one
 * @returns {{ids: number[], points: number[][]}} none where it is not seen whole
 */
export function findChessboard(image, squares, { inverted = false, full = true } = {}) {
  const wanted = [squares[0] - 1, squares[1] - 1];
  /** @type {{ids: number[], points: number[][]}} */
  let best = { ids: [], points: [] };
  for (const lattice of lattices(image, full ? FULL_SIDES_PX : TRACKING_SIDES_PX)) {
    const sides = [lattice.columns, lattice.rows];
    const turned = sides[0] === wanted[1] && sides[1] === wanted[0];
    if (!(turned || (sides[0] === wanted[0] && sides[1] === wanted[1]))) continue;
    if (lattice.points.filter(Boolean).length < MIN_SEEN_SHARE * lattice.points.length) continue;
    const seen = numbered(refined(image, lattice), wanted[0], inverted);
    if (seen.ids.length > best.ids.length) best = seen;
    if (best.ids.length === wanted[0] * wanted[1]) break;
  }
  return best;
}

/**
 * Chessboard of any size: its squares, where a lattice is found.
 * @param {Grey} image
 * @returns {{squares: [number, number], points: number[][], isPlain: boolean} | null} squares: the longer side first;
 *   isPlain: its squares hold no markers
 */
export function recogniseChessboard(image) {
  for (const { columns, rows, points } of lattices(image, WORKING_SIDES_PX)) {
    const seen = /** @type {number[][]} */ (points.filter(Boolean));
    if (columns < MIN_SIDE_CORNERS || rows < MIN_SIDE_CORNERS || seen.length < MIN_SEEN_SHARE * points.length) continue;
    const squares = /** @type {[number, number]} */ (
      columns >= rows ? [columns + 1, rows + 1] : [rows + 1, columns + 1]
    );
    return { squares, points: seen, isPlain: isPlain(image, columns, rows, points) };
  }
  return null;
}

/**
 * True if neither the black nor the white squares hold anything.
 * @param {Grey} image
 * @param {number} columns
 * @param {number} rows
 * @param {([number, number] | null)[]} points
 */
function isPlain({ width, data }, columns, rows, points) {
  const groups = [0, 1].map((parity) => {
    /** @type {{mean: number, deviation: number}[]} */
    const cells = [];
    for (let index = 0; index < (rows - 1) * columns; index++) {
      const [i, j] = [index % columns, Math.floor(index / columns)];
      const quad = [index, index + 1, index + columns + 1, index + columns].map((each) => points[each]);
      const [a, b, c, d] = quad;
      if (i + 1 === columns || (i + j) % 2 !== parity || !a || !b || !c || !d) continue;
      const values = CELL_PLACES.flatMap((v) =>
        CELL_PLACES.map((u) => {
          const [x, y] = [0, 1].map((k) => (1 - v) * ((1 - u) * a[k] + u * b[k]) + v * ((1 - u) * d[k] + u * c[k]));
          return data[Math.round(y) * width + Math.round(x)];
        }),
      );
      const mean = values.reduce((sum, value) => sum + value, 0) / values.length;
      cells.push({
        mean,
        deviation: Math.sqrt(values.reduce((sum, value) => sum + (value - mean) ** 2, 0) / values.length),
      });
    }
    return { mean: median(cells.map(({ mean }) => mean)), deviation: median(cells.map(({ deviation }) => deviation)) };
  });
  const contrast = Math.abs(groups[0].mean - groups[1].mean);
  return groups.every(({ deviation }) => deviation < MAX_PLAIN_DEVIATION * contrast);
}

/**
 * @param {Grey} image
 * @param {number[]} sides px
 * @returns {Generator<Lattice>} of each size at which there is one, in pixels of the image
 */
function* lattices(image, sides) {
  const longer = Math.max(image.width, image.height);
  const factors = [...new Set(sides.map((side) => Math.max(1, Math.round(longer / side))))];
  for (const factor of factors) {
    const small = shrunk(image, factor);
    const lattice = findLattice(small, saddlePoints(small));
    if (lattice)
      yield {
        ...lattice,
        points: lattice.points.map(
          (point) => point && [factor * (point[0] + 0.5) - 0.5, factor * (point[1] + 0.5) - 0.5],
        ),
      };
  }
}

/** The mean of squares of pixels. @param {Grey} image @param {number} factor @returns {Grey} */
export function shrunk(image, factor) {
  if (factor === 1) return image;
  const [width, height] = [Math.floor(image.width / factor), Math.floor(image.height / factor)];
  const data = new Uint8Array(width * height);
  for (let y = 0, to = 0; y < height; y++) {
    for (let x = 0; x < width; x++, to++) {
      let sum = 0;
      for (let j = 0; j < factor; j++) {
        let at = (y * factor + j) * image.width + x * factor;
        for (let i = 0; i < factor; i++, at++) sum += image.data[at];
      }
      data[to] = Math.round(sum / (factor * factor));
    }
  }
  return { width, height, data };
}

/**
 * Corners to a fraction of a pixel; those that have none are dropped.
 * @param {Grey} image
 * @param {Lattice} lattice
 * @returns {Lattice}
 */
function refined(image, { columns, rows, points, firstIsBlack }) {
  const side = (/** @type {number} */ index) => {
    const here = points[index];
    const column = index % columns;
    const others = [
      index - columns,
      index + columns,
      ...(column > 0 ? [index - 1] : []),
      ...(column + 1 < columns ? [index + 1] : []),
    ];
    const distances = others
      .map((other) => points[other])
      .filter((other) => other)
      .map((other) =>
        Math.hypot(
          /** @type {number[]} */ (other)[0] - /** @type {number[]} */ (here)[0],
          /** @type {number[]} */ (other)[1] - /** @type {number[]} */ (here)[1],
        ),
      );
    return Math.min(...distances);
  };
  const better = points.map((point, index) => {
    if (!point) return null;
    const square = side(index);
    if (!Number.isFinite(square)) return null;
    // Twice: a coarse position needs a wide window, which takes in what is bent by the lens.
    const reach = Math.round(Math.min(3 * MAX_WINDOW_PX, Math.max(MIN_WINDOW_PX + 1, 0.3 * square)));
    const wide = refineCorner(image, point[0], point[1], reach, WIDE_TOLERANCE_PX);
    const half = Math.round(Math.min(MAX_WINDOW_PX, Math.max(MIN_WINDOW_PX, WINDOW_SHARE * square)));
    const fine = wide && refineCorner(image, wide[0], wide[1], half);
    return fine && Math.hypot(fine[0] - point[0], fine[1] - point[1]) < 0.3 * square ? fine : null;
  });
  return { columns, rows, points: better, firstIsBlack };
}

/**
 * Ids of the corners: row by row from the one next to the first square, which is black unless the board is inverted.
 * Where the colours leave a choice, from the one nearest the top left of the picture: half a turn does not change the
 * intrinsics.
 * @param {Lattice} lattice @param {number} across corners in a row of the board @param {boolean} inverted
 */
function numbered({ columns, rows, points, firstIsBlack }, across, inverted) {
  /** @type {{at: (row: number, column: number) => number, black: boolean, first: number}[]} */
  const turns = [];
  const even = (/** @type {number} */ value) => value % 2 === 0;
  for (const quarter of [0, 1, 2, 3]) {
    if ((even(quarter) ? columns : rows) !== across) continue;
    const at = (/** @type {number} */ row, /** @type {number} */ column) =>
      [
        row * columns + column,
        (rows - 1 - column) * columns + row,
        (rows - 1 - row) * columns + columns - 1 - column,
        column * columns + columns - 1 - row,
      ][quarter];
    // Colour of the square within the first four corners of the turned lattice, counted from the lattice's own first.
    const [i, j] = [
      [0, 0],
      [0, rows - 2],
      [columns - 2, rows - 2],
      [columns - 2, 0],
    ][quarter];
    const corner = points[at(0, 0)];
    turns.push({
      at,
      black: even(i + j) ? firstIsBlack : !firstIsBlack,
      first: corner ? corner[0] + corner[1] : Infinity,
    });
  }
  const right = turns.filter(({ black }) => black !== inverted);
  const [chosen] = (right.length ? right : turns).sort((a, b) => a.first - b.first);
  /** @type {{ids: number[], points: number[][]}} */
  const found = { ids: [], points: [] };
  for (let id = 0; id < columns * rows; id++) {
    const point = points[chosen.at(Math.floor(id / across), id % across)];
    if (!point) continue;
    found.ids.push(id);
    found.points.push(point);
  }
  return found;
}
