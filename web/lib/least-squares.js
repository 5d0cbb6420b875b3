// Nonlinear least squares of a few parameters.
import { solveLinear } from "./homography.js";

const ITERATIONS = 12;
const DIFFERENCE_STEP = 1e-6; // of forward differences

/**
 * Minimizes a sum of squares by Levenberg–Marquardt, with derivatives by forward differences.
 * @param {(at: number[]) => number[]} residuals @param {number[]} start
 * @returns {number[]} a local minimum
 */
export function minimize(residuals, start) {
  let at = start;
  let r = residuals(at);
  let damping = 1e-3;
  for (let iteration = 0; iteration < ITERATIONS; iteration++) {
    const columns = at.map((_, k) => {
      const shifted = residuals(at.map((value, index) => (index === k ? value + DIFFERENCE_STEP : value)));
      return shifted.map((value, index) => (value - r[index]) / DIFFERENCE_STEP);
    });
    const normal = columns.map((a, i) => [
      ...columns.map((b, j) => dot(a, b) * (i === j ? 1 + damping : 1)),
      -dot(a, r),
    ]);
    const step = solveLinear(normal).solution;
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
