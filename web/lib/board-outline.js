// Outline of the board in the image, from the corners that were detected.
import { corners as boardCorners, outline } from "./board.js";
import { apply, homography } from "./homography.js";

/** @import { Board } from "./board.js" */

/**
 * @typedef {{ids: number[], points: number[][]}} Corners corners of the board that were found; points: px
 */

/** Two squares apart at least, or the outline is a guess. */
const MIN_CORNERS = 6;

/** @param {Board} board @param {Corners} seen @returns {[number, number][] | null} the board's outline, px */
export function observedOutline(board, { ids, points }) {
  if (ids.length < MIN_CORNERS) return null;
  const places = boardCorners(board);
  const h = homography(
    ids.map((id) => places[id]),
    points,
  );
  if (!h) return null;
  // A vertex beyond the horizon comes back on the other side, and the polygon is no longer convex.
  const vertices = outline(board).map((vertex) => apply(h, vertex));
  return turns(vertices).every((turn) => turn > 0) || turns(vertices).every((turn) => turn < 0) ? vertices : null;
}

/**
 * Tilt of a board from facing the camera: 0 for opposite sides of equal length, 0.3 for one that is 30 % longer.
 * @param {number[][]} vertices of a quadrilateral
 */
export function foreshortening(vertices) {
  const sides = vertices.map(([x, y], index) => {
    const [u, v] = vertices[(index + 1) % 4];
    return Math.hypot(u - x, v - y);
  });
  return Math.max(
    ...[0, 1].map((side) => {
      const [a, b] = [sides[side], sides[side + 2]];
      return Math.max(a, b) / Math.min(a, b) - 1;
    }),
  );
}

/** @param {number[][]} vertices @returns {number[]} cross products of successive sides */
function turns(vertices) {
  return vertices.map(([x, y], index) => {
    const [[a, b], [c, d]] = [vertices[(index + 1) % 4], vertices[(index + 2) % 4]];
    return (a - x) * (d - b) - (b - y) * (c - a);
  });
}
