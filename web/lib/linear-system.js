// Small dense linear systems.

/**
 * Solves a system by Gaussian elimination with partial pivoting.
 * @template {number[] | Float64Array} Row @param {Row[]} rows n x (n + 1), the right side last; overwritten
 * @returns {{solution: number[], pivot: number}} pivot: the smallest in size; 0 or NaN where there is no solution
 */
export function solveLinear(rows) {
  const n = rows.length;
  let smallest = Infinity;
  for (let column = 0; column < n; column++) {
    let pivot = column;
    for (let row = column + 1; row < n; row++) {
      if (Math.abs(rows[row][column]) > Math.abs(rows[pivot][column])) pivot = row;
    }
    smallest = Math.min(smallest, Math.abs(rows[pivot][column]));
    [rows[column], rows[pivot]] = [rows[pivot], rows[column]];
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
  return { solution, pivot: smallest };
}
