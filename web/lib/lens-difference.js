// Difference of two calibrations of one camera: how far apart they show a ray, after the best rotation. Pure.
import { minimize } from "./least-squares.js";
import { rotate, rotationMatrix } from "../sdk/motion.js";
import { lensOf } from "../sdk/projection.js";

/** @typedef {import("../sdk/projection.js").Intrinsics & {img_size: [number, number]}} Lens */

const GRID = /** @type {[number, number]} */ ([20, 12]); // columns and rows
const FAR_PX = 1e4; // px; of a ray that the other lens does not see

/**
 * @param {Lens} one @param {Lens} other of the same picture size
 * @returns {{px: (number | null)[][], rms: number, max: number}} px: at the centres of cells; null: one of them sees no
 *   ray there
 */
export function lensDifference(one, other) {
  const [width, height] = one.img_size;
  const [columns, rows] = GRID;
  const [first, second] = [lensOf(one), lensOf(other)];
  const points = Array.from(
    { length: columns * rows },
    (_, index) =>
      /** @type {[number, number]} */ ([
        ((index % columns) + 0.5) * (width / columns) - 0.5,
        (Math.floor(index / columns) + 0.5) * (height / rows) - 0.5,
      ]),
  );
  const rays = points.map((point) => first.unproject(point));
  const apart = (/** @type {number[]} */ rotation) => {
    const matrix = rotationMatrix(rotation);
    return points.map((point, index) => {
      const ray = rays[index];
      const seen = ray && second.project(/** @type {[number, number, number]} */ (rotate(matrix, ray)));
      return seen ? [seen[0] - point[0], seen[1] - point[1]] : null;
    });
  };
  const rotation = minimize(
    (at) => apart(at).flatMap((d, index) => d ?? (rays[index] ? [FAR_PX, FAR_PX] : [0, 0])),
    [0, 0, 0],
  );
  const lengths = apart(rotation).map((d) => d && Math.hypot(d[0], d[1]));
  const there = lengths.filter((each) => each !== null);
  return {
    px: Array.from({ length: rows }, (_, row) => lengths.slice(row * columns, (row + 1) * columns)),
    rms: Math.sqrt(there.reduce((sum, each) => sum + each * each, 0) / Math.max(1, there.length)),
    max: Math.max(0, ...there),
  };
}
