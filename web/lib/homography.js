// The board's plane in the image, before any intrinsics are known, and the small linear systems that determine it.

const MIN_PIVOT = 1e-9; // of normalised coordinates

/** @typedef {number[]} Homography row-major 3x3 */

/**
 * Direct linear transform, both sides normalised (Hartley 1997), least squares over all points.
 * @param {number[][]} from @param {number[][]} to at least four points, no three of four on a line
 * @returns {Homography | null} null where the points do not determine one
 */
export function homography(from, to) {
  if (from.length < 4 || from.length !== to.length) return null;
  const [a, b] = [normaliser(from), normaliser(to)];
  // h33 = 1 after normalisation: the centroid of the points is never at infinity.
  const normal = Array.from({ length: 8 }, () => new Float64Array(9));
  from.forEach((_, index) => {
    const [x, y] = a.apply(from[index]);
    const [u, v] = b.apply(to[index]);
    for (const row of [
      [x, y, 1, 0, 0, 0, -u * x, -u * y, u],
      [0, 0, 0, x, y, 1, -v * x, -v * y, v],
    ]) {
      for (let i = 0; i < 8; i++) for (let j = 0; j < 9; j++) normal[i][j] += row[i] * row[j];
    }
  });
  const { solution, pivot } = solveLinear(normal);
  if (!(pivot >= MIN_PIVOT)) return null; // NaN too
  const h = [...solution, 1];
  const toPixels = [1 / b.scale, 0, b.x, 0, 1 / b.scale, b.y, 0, 0, 1];
  const fromBoard = [a.scale, 0, -a.scale * a.x, 0, a.scale, -a.scale * a.y, 0, 0, 1];
  return multiply(multiply(toPixels, h), fromBoard);
}

/** @param {Homography} h @param {number[]} point @returns {[number, number]} */
export function apply(h, [x, y]) {
  const w = h[6] * x + h[7] * y + h[8];
  return [(h[0] * x + h[1] * y + h[2]) / w, (h[3] * x + h[4] * y + h[5]) / w];
}

/** @param {number[][]} points */
function normaliser(points) {
  const x = points.reduce((sum, point) => sum + point[0], 0) / points.length;
  const y = points.reduce((sum, point) => sum + point[1], 0) / points.length;
  const spread = points.reduce((sum, point) => sum + Math.hypot(point[0] - x, point[1] - y), 0) / points.length;
  const scale = spread > 0 ? Math.SQRT2 / spread : 1;
  return { x, y, scale, apply: (/** @type {number[]} */ point) => [(point[0] - x) * scale, (point[1] - y) * scale] };
}

/** @param {Homography} a @param {Homography} b */
function multiply(a, b) {
  return Array.from({ length: 9 }, (_, index) => {
    const [row, column] = [3 * Math.floor(index / 3), index % 3];
    return a[row] * b[column] + a[row + 1] * b[3 + column] + a[row + 2] * b[6 + column];
  });
}

/**
 * Solves a system by Gaussian elimination with partial pivoting.
 * @template {number[] | Float64Array} Row @param {Row[]} rows n x (n + 1), the right side last; overwritten
 * @returns {{solution: number[], pivot: number}} pivot: the smallest in size; 0 or NaN if the system is singular
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
