// Nonlinear least squares of a few parameters.

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
      ...columns.map((b, j) => dot(a, b) * (i === j ? 1 + damping : 1)), -dot(a, r),
    ]);
    const step = solve(normal);
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
function solve(rows) {
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
