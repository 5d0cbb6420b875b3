// House in the middle of the board: walls, a gable roof that juts out, a chimney, a door and windows.
import { shadedFaces } from "./triangles.js";

/** @import { Colour, Point } from "./triangles.js" */

/** @type {Colour} */
const WALLS = [1, 0.94, 0.82];
/** @type {Colour} */
const ROOF = [0.93, 0.33, 0.16];
/** @type {Colour} */
const BRICKS = [0.62, 0.32, 0.24];
/** @type {Colour} */
const DOOR = [0.42, 0.24, 0.12];
/** @type {Colour} */
const PANES = [0.24, 0.42, 0.56];
const HAIR = 0.012; // squares: distance of doors and windows in front of their wall

/**
 * A house about the middle of a board; its door faces the board's lower edge.
 * @param {number} columns @param {number} rows
 * @returns {number[]} six numbers a vertex
 */
export function house(columns, rows) {
  const size = Math.min(columns, rows) / 6;
  /**
   * Units of the house, z towards the viewer, to the board's frame.
   * @type {(x: number, y: number, z: number) => Point}
   */
  const at = (x, y, z) => [columns / 2 + x * size, rows / 2 + y * size, -z * size];
  const [w, d, eaves, ridge, jut] = [0.95, 0.75, 0.85, 1.6, 0.14];
  // The walls end a hair below the roof: in the same plane the two would flicker.
  const [wall, gable] = [eaves - 2 * HAIR, ridge - 3 * HAIR];
  const low = eaves - (jut * (ridge - eaves)) / d;
  /** @param {number} y a wall that faces up or down @param {number[]} span left, right, bottom, top */
  const inFront = (y, [left, right, bottom, top]) => {
    const face = [at(left, y, bottom), at(right, y, bottom), at(right, y, top), at(left, y, top)];
    return y > 0 ? face.reverse() : face;
  };
  /** @param {number} x a wall that faces left or right @param {number[]} span */
  const sideWall = (x, [left, right, bottom, top]) => {
    const face = [at(x, left, bottom), at(x, right, bottom), at(x, right, top), at(x, left, top)];
    return x > 0 ? face : face.reverse();
  };
  return [
    ...shadedFaces(WALLS, [
      inFront(-d, [-w, w, 0, wall]),
      inFront(d, [-w, w, 0, wall]),
      sideWall(-w, [-d, d, 0, wall]),
      sideWall(w, [-d, d, 0, wall]),
      [at(w, -d, wall), at(w, d, wall), at(w, 0, gable)],
      [at(-w, d, wall), at(-w, -d, wall), at(-w, 0, gable)],
    ]),
    ...shadedFaces(ROOF, [
      [at(-w - jut, -d - jut, low), at(w + jut, -d - jut, low), at(w + jut, 0, ridge), at(-w - jut, 0, ridge)],
      [at(w + jut, d + jut, low), at(-w - jut, d + jut, low), at(-w - jut, 0, ridge), at(w + jut, 0, ridge)],
    ]),
    ...chimney(at, 0.5, -0.4, 0.13, 1.75),
    ...shadedFaces(DOOR, [inFront(d + HAIR, [-0.16, 0.16, 0, 0.56])]),
    ...shadedFaces(PANES, [
      inFront(d + HAIR, [-0.7, -0.38, 0.3, 0.62]),
      inFront(d + HAIR, [0.38, 0.7, 0.3, 0.62]),
      inFront(-d - HAIR, [-0.6, -0.2, 0.3, 0.62]),
      inFront(-d - HAIR, [0.2, 0.6, 0.3, 0.62]),
      sideWall(w + HAIR, [-0.2, 0.2, 0.3, 0.62]),
      sideWall(-w - HAIR, [-0.2, 0.2, 0.3, 0.62]),
    ]),
  ];
}

/** Places of the vertices of a house, each once. @param {number} columns @param {number} rows @returns {number[][]} */
export function housePoints(columns, rows) {
  const numbers = house(columns, rows);
  const places = new Map();
  for (let n = 0; n < numbers.length; n += 6) {
    const place = numbers.slice(n, n + 3);
    places.set(place.join(), place);
  }
  return [...places.values()];
}

/**
 * @param {(x: number, y: number, z: number) => Point} at
 * @param {number} x
 * @param {number} y
 * @param {number} half
 * @param {number} top
 */
function chimney(at, x, y, half, top) {
  const corners = (/** @type {number} */ z) => [
    at(x - half, y - half, z),
    at(x + half, y - half, z),
    at(x + half, y + half, z),
    at(x - half, y + half, z),
  ];
  const [foot, head] = [corners(0.9), corners(top)];
  return shadedFaces(BRICKS, [
    ...[0, 1, 2, 3].map((side) => {
      const next = (side + 1) % 4;
      return [foot[side], foot[next], head[next], head[side]];
    }),
    head,
  ]);
}
