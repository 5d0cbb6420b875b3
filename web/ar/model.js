// Model that stands on the board: its own grid once more, a cross on each of the four outermost corners, and a house.
// Triangles in the board's frame (x right, y down, z away from the viewer; unit: one square), shaded once and
// for all.
import { house } from "./house.js";
import { quadrilateral } from "./triangles.js";

/** @import { Colour } from "./triangles.js" */

const LINE = 0.05; // squares, width
const MARK = 0.3; // squares, half the length of a cross
/** @type {Colour} */
const GRID = [1, 0.69, 0];
/** @type {Colour} */
const MARKS = [0, 0.88, 1];

/**
 * @param {import("../lib/board.js").Board} board
 * @returns {Float32Array} six numbers a vertex, place and colour; three vertices a triangle
 */
export function model({ squares: [columns, rows] }) {
  return new Float32Array([...grid(columns, rows), ...marks(columns, rows), ...house(columns, rows)]);
}

/** @param {number} columns @param {number} rows */
function grid(columns, rows) {
  const numbers = [];
  for (let x = 0; x <= columns; x++) numbers.push(...across([x, rows / 2], LINE / 2, (rows + LINE) / 2, 0, GRID));
  for (let y = 0; y <= rows; y++) numbers.push(...across([columns / 2, y], (columns + LINE) / 2, LINE / 2, 0, GRID));
  return numbers;
}

/** A hair above the lines. @param {number} columns @param {number} rows */
function marks(columns, rows) {
  const corners = [
    [1, 1],
    [columns - 1, 1],
    [columns - 1, rows - 1],
    [1, rows - 1],
  ];
  return corners.flatMap((corner) => [
    ...across(corner, MARK, LINE / 2, -0.002, MARKS),
    ...across(corner, LINE / 2, MARK, -0.002, MARKS),
  ]);
}

/**
 * A rectangle about a middle.
 * @param {number[]} middle
 * @param {number} right half its width
 * @param {number} down half its height
 * @param {number} z
 * @param {Colour} colour
 */
const across = ([x, y], right, down, z, colour) =>
  quadrilateral(
    [
      [x - right, y - down, z],
      [x + right, y - down, z],
      [x + right, y + down, z],
      [x - right, y + down, z],
    ],
    colour,
  );
