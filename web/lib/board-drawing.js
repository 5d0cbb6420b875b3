// Black areas of a board. Separate from its geometry, because only drawing needs the tables of the markers.
import { TABLES } from "../vendor/dictionaries.js";
import { DEFAULT_TAG_SPACING, corners, dictionaryOf, isBlack, isCircles, markers, sizeOf } from "./board.js";

/** @import { Board } from "./board.js" */

/**
 * @typedef {[x: number, y: number, width: number, height: number]} Rectangle
 */

/** Width of the black frame of a tag, cells: as Kalibr prints AprilGrids; of other markers it is one. */
const TAG_BORDER = 2;
const TIE = 1e-6; // px: two neighbours agree on an edge in the middle of a pixel, whatever their last digits
const DISK_ROWS = 96; // of a circle: finer than a printer's or a screen's

/**
 * The bits of one marker without its border.
 * @param {string} dictionary
 * @param {number} id
 * @returns {boolean[][]} rows of cells, true = white
 */
export function markerBits(dictionary, id) {
  const { size, side, count } = dictionaryOf(dictionary);
  if (id >= count) throw new RangeError(`${dictionary} has ${count} markers, and the board needs number ${id}`);
  const packed = unpack(TABLES[size].bits);
  return Array.from({ length: side }, (_, row) =>
    Array.from({ length: side }, (_, column) => {
      const bit = (id * side + row) * side + column;
      return ((packed[bit >> 3] >> (7 - (bit & 7))) & 1) === 1;
    }),
  );
}

/** @type {Map<string, Uint8Array>} */
const unpacked = new Map();

/** @param {string} base64 */
function unpack(base64) {
  let bytes = unpacked.get(base64);
  if (!bytes) {
    bytes = Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
    unpacked.set(base64, bytes);
  }
  return bytes;
}

/**
 * The black areas of the board: squares, marker borders, and runs of black cells within markers.
 * @param {Board} board
 * @returns {Rectangle[]} board units from the upper left corner; no two overlap
 */
export function blackRectangles(board) {
  const draw = isCircles(board) ? diskRectangles : board.kind === "aprilgrid" ? tagRectangles : squareRectangles;
  const drawn = draw(board);
  return board.inverted ? complement(drawn, sizeOf(board)) : drawn;
}

/** Circles as thin rows, each as wide as the circle in its middle. @param {Board} board */
function diskRectangles(board) {
  const radius = board.marker_ratio / 2;
  const height = (2 * radius) / DISK_ROWS;
  return corners(board).flatMap(([x, y]) =>
    Array.from({ length: DISK_ROWS }, (_, row) => {
      const off = (row + 0.5) * height - radius;
      const half = Math.sqrt(radius * radius - off * off);
      return /** @type {Rectangle} */ ([x - half, y + off - height / 2, 2 * half, height]);
    }),
  );
}

/** Tags of an AprilGrid, and the squares in the gaps between them. @param {Board} board */
function tagRectangles(board) {
  const [columns, rows] = board.squares;
  const spacing = board.tag_spacing ?? DEFAULT_TAG_SPACING;
  /** @type {Rectangle[]} */
  const rectangles = [];
  for (const { id, x, y } of markers(board)) {
    const [left, top] = [x * (1 + spacing), (rows - 1 - y) * (1 + spacing)];
    rectangles.push(...markerRectangles(markerBits(board.dictionary, id), left, top, 1, TAG_BORDER));
    if (x + 1 < columns && y > 0) rectangles.push([left + 1, top + 1, spacing, spacing]);
  }
  return rectangles;
}

/**
 * Areas that rectangles leave free.
 * @param {Rectangle[]} rectangles
 * @param {[number, number]} size
 * @returns {Rectangle[]}
 */
function complement(rectangles, [width, height]) {
  const edges = [
    ...new Set([0, height, ...rectangles.flatMap(([, y, , h]) => [y, y + h])].map((y) => Math.round(1e9 * y) / 1e9)),
  ].sort((a, b) => a - b);
  /** @type {Rectangle[]} */
  const free = [];
  for (let index = 0; index + 1 < edges.length; index++) {
    const [top, bottom] = [edges[index], edges[index + 1]];
    const middle = (top + bottom) / 2;
    const across = rectangles.filter(([, y, , h]) => y <= middle && middle < y + h).sort((a, b) => a[0] - b[0]);
    let left = 0;
    for (const [x, , w] of [...across, [width, 0, 0]]) {
      if (x - left > 1e-9) free.push([left, top, x - left, bottom - top]);
      left = Math.max(left, x + w);
    }
  }
  return free;
}

/** @param {Board} board */
function squareRectangles(board) {
  const [columns, rows] = board.squares;
  /** @type {Rectangle[]} */
  const rectangles = [];
  for (let y = 0; y < rows; y++) {
    for (let x = 0; x < columns; x++) if (isBlack(board, x, y)) rectangles.push([x, y, 1, 1]);
  }
  for (const { id, x, y } of markers(board)) {
    const margin = (1 - board.marker_ratio) / 2;
    rectangles.push(...markerRectangles(markerBits(board.dictionary, id), x + margin, y + margin, board.marker_ratio));
  }
  return rectangles;
}

/**
 * Black areas of one marker.
 * @param {boolean[][]} bits
 * @param {number} left
 * @param {number} top
 * @param {number} side
 * @param {number} [border] cells
 * @returns {Rectangle[]}
 */
function markerRectangles(bits, left, top, side, border = 1) {
  const cells = bits.length + 2 * border;
  const cell = side / cells;
  /** @type {Rectangle[]} */
  const rectangles = [];
  for (let row = 0; row < cells; row++) {
    let run = 0;
    for (let column = 0; column <= cells; column++) {
      const black = column < cells && !bits[row - border]?.[column - border];
      if (black) run += 1;
      else if (run > 0) {
        rectangles.push([left + (column - run) * cell, top + row * cell, run * cell, cell]);
        run = 0;
      }
    }
  }
  return rectangles;
}

const MAX_SHRINK = 0.8; // of the size that there is room for
const WHOLE = 0.02; // pixels by which a tag may miss its place

/**
 * Largest scale at which every corner falls on the edge of a pixel: between the tags of an AprilGrid it rarely does.
 * @param {Board} board @param {number} most pixels per board unit that there is room for, whole
 */
export function exactScale({ kind, tag_spacing: spacing = DEFAULT_TAG_SPACING }, most) {
  if (kind !== "aprilgrid") return most;
  const misses = (/** @type {number} */ scale) => Math.abs(scale * spacing - Math.round(scale * spacing));
  let best = most;
  for (let scale = most; scale >= MAX_SHRINK * most && misses(best) > WHOLE; scale--)
    if (misses(scale) < misses(best)) best = scale;
  return best;
}

/**
 * The board as a grey image.
 * @param {Board} board
 * @param {number} scale pixels per board unit
 * @param {number} [margin] border, pixels: white, of an inverted board black
 * @returns {{width: number, height: number, data: Uint8Array}} one byte a pixel, 0 or 255
 */
export function raster(board, scale, margin = 0) {
  const [across, down] = sizeOf(board);
  const width = Math.round(across * scale) + 2 * margin;
  const height = Math.round(down * scale) + 2 * margin;
  const data = new Uint8Array(width * height).fill(board.inverted ? 0 : 255);
  for (let row = margin; board.inverted && row < height - margin; row++)
    data.fill(255, row * width + margin, (row + 1) * width - margin);
  for (const [x, y, w, h] of blackRectangles(board)) {
    const [left, right, top, bottom] = [x, x + w, y, y + h].map((value) => margin + Math.round(value * scale + TIE));
    for (let row = top; row < bottom; row++) data.fill(0, row * width + left, row * width + right);
  }
  return { width, height, data };
}
