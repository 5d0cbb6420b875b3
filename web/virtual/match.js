// A person does not read numbers: the board is held so that it covers its outline, whatever lens the target was drawn for.
import { corners as boardCorners } from "../board/geometry.js";
import { project } from "./lens.js";
import { transform } from "./pose.js";

/**
 * @typedef {import("./pose.js").Pose} Pose
 * @typedef {import("./lens.js").Lens} Lens
 */

const ROUNDS = 12;
const STEP = 1e-6;
const ENOUGH = 12; // corners; more would say the same, slower

/**
 * The pose in which this lens sees the board's corners nearest to where they are asked for.
 * @param {import("../board/geometry.js").Board} board @param {Lens} lens
 * @param {Pose & {ids?: readonly number[], corners?: readonly (readonly number[])[]}} target
 * @returns {Pose} the target's own where it shows too little of the board
 */
export function matched(board, lens, { rvec, tvec, ids = [], corners = [] }) {
  if (ids.length < 6) return { rvec, tvec };
  const places = boardCorners(board);
  const every = Math.max(1, Math.floor(ids.length / ENOUGH));
  const used = ids.map((_, index) => index).filter((index) => index % every === 0 || index === ids.length - 1);
  const points = used.map((index) => [...places[ids[index]], 0]);
  /** @param {number[]} parameters */
  const residuals = (parameters) => {
    const pose = { rvec: parameters.slice(0, 3), tvec: parameters.slice(3) };
    return points.flatMap((point, n) => {
      const index = used[n];
      const p = transform(pose, point);
      if (p[2] < 0.1) return [1e3, 1e3];
      const [u, v] = project(lens, p);
      return [u - corners[index][0], v - corners[index][1]];
    });
  };
  const at = fitted(residuals, [...rvec, ...tvec]);
  return { rvec: at.slice(0, 3), tvec: at.slice(3) };
}

/**
 * Least squares by Levenberg–Marquardt, derivatives by differences.
 * @param {(at: number[]) => number[]} residuals @param {number[]} start
 * @returns {number[]} where the sum of their squares is smallest nearby
 */
export function fitted(residuals, start) {
  let at = start;
  let r = residuals(at);
  let damping = 1e-3;
  for (let round = 0; round < ROUNDS; round++) {
    const columns = at.map((_, k) => {
      const moved = residuals(at.map((value, index) => (index === k ? value + STEP : value)));
      return moved.map((value, index) => (value - r[index]) / STEP);
    });
    const normal = columns.map((a, i) => [
      ...columns.map((b, j) => dot(a, b) * (i === j ? 1 + damping : 1)), -dot(a, r),
    ]);
    const step = solved(normal);
    const next = at.map((value, index) => value + step[index]);
    const better = residuals(next);
    const improved = dot(better, better) < dot(r, r);
    damping *= improved ? 0.1 : 10;
    if (improved) [at, r] = [next, better];
  }
  return at;
}

/** @param {number[]} a @param {number[]} b */
const dot = (a, b) => a.reduce((sum, value, index) => sum + value * b[index], 0);

/** Gaussian elimination of a positive definite system. @param {number[][]} rows n x (n+1) */
function solved(rows) {
  const n = rows.length;
  for (let column = 0; column < n; column++) {
    for (let row = column + 1; row < n; row++) {
      const factor = rows[row][column] / rows[column][column];
      for (let k = column; k <= n; k++) rows[row][k] -= factor * rows[column][k];
    }
  }
  const solution = new Array(n).fill(0);
  for (let row = n - 1; row >= 0; row--) {
    let value = rows[row][n];
    for (let k = row + 1; k < n; k++) value -= rows[row][k] * solution[k];
    solution[row] = value / rows[row][row];
  }
  return solution;
}
