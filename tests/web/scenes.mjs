// Boards as a simulated camera sees them.
import { corners } from "../../web/lib/board.js";
import { transformPoint } from "../../web/lib/pose.js";
import { projectionOf } from "../../web/lib/virtual/lens.js";
import { Painter } from "../../web/lib/virtual/painter.js";

/** Pixels of points of the board's plane. */
export function see(lens, pose, places) {
  const { project } = projectionOf(lens);
  return places.map(([x, y]) => project(transformPoint(pose, [x, y, 0])));
}

/** All corners of a board, as a detector gives them. */
export function cornersSeen(board, lens, pose) {
  const points = see(lens, pose, corners(board));
  return { ids: points.map((_, id) => id), points };
}

/** Grey picture of a board; pose null: of a wall. */
export function photograph(board, lens, [width, height], pose) {
  const rgba = new Uint8ClampedArray(4 * width * height);
  new Painter(board, lens, [width, height]).paint(pose, rgba);
  return { width, height, data: Uint8Array.from({ length: width * height }, (_, pixel) => rgba[4 * pixel]) };
}
