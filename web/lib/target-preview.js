// Preview of the target: the board's black squares, drawn through the same lens as its corners.
import { isBlack } from "./board.js";

/**
 * @typedef {import("./board.js").Board} Board
 * @typedef {number[][]} Polygon
 */

/**
 * Black squares of the board in a pose, or its tags. The inner vertices are the service's and exact; those at the
 * board's edge are extrapolated from the two before them.
 * @param {Board} board @param {{ids: number[], corners: number[][]}} pose
 * @returns {Polygon[]} px
 */
export function blackSquares(board, { ids, corners }) {
  const [columns, rows] = board.squares;
  if (board.kind === "aprilgrid") return tags(columns * rows, new Map(ids.map((id, index) => [id, corners[index]])));
  const vertex = vertexOf(board, { ids, corners });
  /** @type {Polygon[]} */
  const squares = [];
  for (let y = 0; y < rows; y++) {
    for (let x = 0; x < columns; x++) {
      if (!isBlack(board, x, y)) continue;
      const vertices = [vertex(x, y), vertex(x + 1, y), vertex(x + 1, y + 1), vertex(x, y + 1)];
      if (vertices.every((each) => each !== null)) squares.push(/** @type {Polygon} */ (vertices));
    }
  }
  return squares;
}

/**
 * Places of a board's vertices, its rim included.
 * @param {Board} board no AprilGrid @param {{ids: number[], corners: number[][]}} pose
 * @returns {(x: number, y: number) => number[] | null} by column and row, squares; null where too few corners are known
 */
export function vertexOf({ squares: [columns, rows] }, { ids, corners }) {
  const place = new Map(ids.map((id, index) => [id, corners[index]]));
  /** @type {(x: number, y: number) => number[] | null} */
  const vertex = (x, y) => {
    if (x === 0) return extrapolate(vertex(1, y), vertex(2, y));
    if (x === columns) return extrapolate(vertex(columns - 1, y), vertex(columns - 2, y));
    if (y === 0) return extrapolate(vertex(x, 1), vertex(x, 2));
    if (y === rows) return extrapolate(vertex(x, rows - 1), vertex(x, rows - 2));
    return place.get((y - 1) * (columns - 1) + x - 1) ?? null;
  };
  return vertex;
}

/** @param {number} count @param {Map<number, number[]>} place of corners by their ids @returns {Polygon[]} px */
function tags(count, place) {
  const polygons = Array.from({ length: count }, (_, tag) => [0, 1, 2, 3].map((corner) => place.get(4 * tag + corner)));
  return /** @type {Polygon[]} */ (polygons.filter((polygon) => polygon.every((vertex) => vertex !== undefined)));
}

/** @param {number[] | null} near @param {number[] | null} next */
const extrapolate = (near, next) => (near && next ? [2 * near[0] - next[0], 2 * near[1] - next[1]] : null);
