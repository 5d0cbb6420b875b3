// Model that stands on the board: its own grid once more, a cross on each of the four outermost corners, and a house. Triangles
// in the board's frame (x right, y down, z away from who looks at it; unit: one square), shaded once and for all.
import { unit } from "./pose.js";

/** @typedef {[number, number, number]} Point */
/** @typedef {[red: number, green: number, blue: number]} Colour 0…1 */

const LINE = 0.05; // squares, width
const MARK = 0.3; // squares, half the length of a cross
/** @type {Colour} */
const GRID = [1, 0.69, 0];
/** @type {Colour} */
const MARKS = [0, 0.88, 1];
/** @type {Colour} */
const WALLS = [0.45, 0.85, 1];
/** @type {Colour} */
const ROOF = [1, 0.42, 0.2];
/** Direction of the light: in front of the board, from below on the left, where one stands who looks at it. */
const LIGHT = unit([-0.5, 0.45, -0.75]);
const AMBIENT = 0.4;

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
  const corners = [[1, 1], [columns - 1, 1], [columns - 1, rows - 1], [1, rows - 1]];
  return corners.flatMap((corner) => [...across(corner, MARK, LINE / 2, -0.002, MARKS), ...across(corner, LINE / 2, MARK, -0.002, MARKS)]);
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
  quadrilateral([[x - right, y - down, z], [x + right, y - down, z], [x + right, y + down, z], [x - right, y + down, z]], colour);

/** In the middle of the board, a quarter of it wide. @param {number} columns @param {number} rows */
function house(columns, rows) {
  const half = Math.min(columns, rows) / 8;
  const [x, y] = [columns / 2, rows / 2];
  /** @param {number} z @returns {Point[]} the four corners at a height */
  const at = (z) => [[x - half, y - half, z], [x + half, y - half, z], [x + half, y + half, z], [x - half, y + half, z]];
  const [ground, eaves] = [at(0), at(-1.3 * half)];
  /** @type {Point} */
  const top = [x, y, -2.4 * half];
  return [0, 1, 2, 3].flatMap((side) => {
    const next = (side + 1) % 4;
    const [wall, slope] = [[ground[side], ground[next], eaves[next], eaves[side]], [eaves[side], eaves[next], top]];
    return [...quadrilateral(wall, shaded(WALLS, wall)), ...triangle(slope, shaded(ROOF, slope))];
  });
}

/**
 * Lambert's law.
 * @param {Colour} colour
 * @param {Point[]} face counterclockwise as seen from outside
 * @returns {Colour}
 */
function shaded(colour, [a, b, c]) {
  const [u, v] = [b.map((value, axis) => value - a[axis]), c.map((value, axis) => value - a[axis])];
  const normal = unit([u[2] * v[1] - u[1] * v[2], u[0] * v[2] - u[2] * v[0], u[1] * v[0] - u[0] * v[1]]);
  const lit = Math.max(0, normal.reduce((sum, value, axis) => sum + value * LIGHT[axis], 0));
  const light = AMBIENT + (1 - AMBIENT) * lit;
  return /** @type {Colour} */ (colour.map((value) => value * light));
}

/** @param {Point[]} corners @param {Colour} colour */
const quadrilateral = ([a, b, c, d], colour) => [...triangle([a, b, c], colour), ...triangle([a, c, d], colour)];

/** @param {Point[]} corners @param {Colour} colour */
const triangle = (corners, colour) => corners.flatMap((corner) => [...corner, ...colour]);
