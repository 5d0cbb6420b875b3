// Black areas of a ChArUco board. Apart from its geometry: only who draws boards needs the tables of the markers.
import { TABLES } from "./dictionaries.js";
import { dictionaryOf, isBlack, markers } from "./board.js";

/**
 * @typedef {import("./board.js").Board} Board
 *
 * @typedef {[x: number, y: number, width: number, height: number]} Rectangle
 */

/**
 * The bits of one marker without its border.
 * @param {string} dictionary
 * @param {number} id
 * @returns {boolean[][]} rows of cells, true = white
 */
function markerBits(dictionary, id) {
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
 * @returns {Rectangle[]} in squares; no two overlap
 */
export function blackRectangles(board) {
  const [columns, rows] = board.squares;
  /** @type {Rectangle[]} */
  const rectangles = [];
  for (let y = 0; y < rows; y++) {
    for (let x = 0; x < columns; x++) if (isBlack(board, x, y)) rectangles.push([x, y, 1, 1]);
  }
  for (const { id, x, y } of markers(board)) {
    const bits = markerBits(board.dictionary, id);
    const cells = bits.length + 2;
    const cell = board.marker_ratio / cells;
    const margin = (1 - board.marker_ratio) / 2;
    for (let row = 0; row < cells; row++) {
      let run = 0;
      for (let column = 0; column <= cells; column++) {
        const black = column < cells && !bits[row - 1]?.[column - 1];
        if (black) run += 1;
        else if (run > 0) {
          rectangles.push([x + margin + (column - run) * cell, y + margin + row * cell, run * cell, cell]);
          run = 0;
        }
      }
    }
  }
  return rectangles;
}

/**
 * The board as a grey image.
 * @param {Board} board
 * @param {number} scale pixels per square
 * @param {number} [margin] white border, pixels
 * @returns {{width: number, height: number, data: Uint8Array}} one byte a pixel, 0 or 255
 */
export function raster(board, scale, margin = 0) {
  const [columns, rows] = board.squares;
  const width = Math.round(columns * scale) + 2 * margin;
  const height = Math.round(rows * scale) + 2 * margin;
  const data = new Uint8Array(width * height).fill(255);
  for (const [x, y, w, h] of blackRectangles(board)) {
    const [left, right] = [x, x + w].map((value) => margin + Math.round(value * scale));
    const [top, bottom] = [y, y + h].map((value) => margin + Math.round(value * scale));
    for (let row = top; row < bottom; row++) data.fill(0, row * width + left, row * width + right);
  }
  return { width, height, data };
}
