// Triangles of the model, six numbers a vertex: place and colour.
import { unit } from "../lib/board-pose.js";

/** @typedef {[number, number, number]} Point */
/** @typedef {[red: number, green: number, blue: number]} Colour 0…1 */

/** Direction of the light: in front of the board, from below on the left, where the viewer is. */
const LIGHT = unit([-0.5, 0.45, -0.75]);
const AMBIENT = 0.4;

/**
 * Lambert's law.
 * @param {Colour} colour
 * @param {Point[]} face counterclockwise as seen from outside
 * @returns {Colour}
 */
function shaded(colour, [a, b, c]) {
  const [u, v] = [b.map((value, axis) => value - a[axis]), c.map((value, axis) => value - a[axis])];
  const normal = unit([u[2] * v[1] - u[1] * v[2], u[0] * v[2] - u[2] * v[0], u[1] * v[0] - u[0] * v[1]]);
  const lit = Math.max(
    0,
    normal.reduce((sum, value, axis) => sum + value * LIGHT[axis], 0),
  );
  const light = AMBIENT + (1 - AMBIENT) * lit;
  return /** @type {Colour} */ (colour.map((value) => value * light));
}

/**
 * Faces of three or four corners, shaded.
 * @param {Colour} colour
 * @param {Point[][]} faces counterclockwise as seen from outside
 */
export const shadedFaces = (colour, faces) =>
  faces.flatMap((face) => (face.length === 3 ? triangle : quadrilateral)(face, shaded(colour, face)));

/** @param {Point[]} corners @param {Colour} colour */
export const quadrilateral = ([a, b, c, d], colour) => [...triangle([a, b, c], colour), ...triangle([a, c, d], colour)];

/** @param {Point[]} corners @param {Colour} colour */
const triangle = (corners, colour) => corners.flatMap((corner) => [...corner, ...colour]);
