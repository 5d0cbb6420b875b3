// Drawing of the examples: a box on the board, and a mark on each of the board's outer corners.
import { DEFAULT_BOARD } from "../lib/board.js";

/**
 * @typedef {[number, number, number]} Point camera frame as everywhere in calibDB: x right, y down, z forward; squares
 *
 * @typedef {object} Drawing
 * @property {Point[]} marks
 * @property {[Point, Point][]} edges
 */

export const MARK = 0.4; // side, squares

/**
 * The board as the virtual camera first shows it: upright, facing the camera, a little farther off than the picture is wide.
 * Before a real camera, where nothing is tracked here, the box stands in the same place.
 * @param {{img_size: readonly [number, number], camera_matrix: number[][]}} calibration @returns {Drawing}
 */
export function drawingFor({ img_size: [width], camera_matrix: [[fx]] }) {
  const [columns, rows] = DEFAULT_BOARD.squares;
  const z = (1.6 * columns * fx) / width;
  const [x, y, high] = [columns / 2, rows / 2, 2];
  /** @type {[number, number][]} */
  const corners = [[-x, -y], [x, -y], [x, y], [-x, y]];
  const at = (/** @type {[number, number]} */ [u, v], /** @type {number} */ up) => /** @type {Point} */ ([u, v, z - up]);
  return {
    marks: corners.map((corner) => at(corner, 0)),
    edges: corners.flatMap((corner, index) => {
      const next = corners[(index + 1) % 4];
      return /** @type {[Point, Point][]} */ ([[at(corner, 0), at(next, 0)], [at(corner, high), at(next, high)], [at(corner, 0), at(corner, high)]]);
    }),
  };
}
