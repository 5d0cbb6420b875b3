// A second pass of corner refinement. OpenCV.js does not bind cornerSubPix, and the window that its ChArUco detector
// uses is not fitted to the squares: too wide a window takes in the marker's edges and makes hard frames worse.

const MAX_REFINEMENTS = 20;
const TOLERANCE_PX = 0.005;
const MIN_SQUARE_PX = 16; // px; below that the window would hold the neighbouring marker
const MAX_SHIFT_PX = 1; // px; a corner that wants to go further was not where the detector thought

/**
 * @typedef {{width: number, height: number, data: Uint8Array}} Grey one byte a pixel
 */

/** @type {Map<number, Float64Array>} Gaussian weights of windows by half their size */
const weights = new Map();

/** @param {number} half px */
function weightsOf(half) {
  let found = weights.get(half);
  if (!found) {
    const side = 2 * half + 1;
    found = Float64Array.from({ length: side * side }, (_, at) => {
      const [i, j] = [(at % side) - half, Math.floor(at / side) - half];
      return Math.exp(-(i * i + j * j) / (half * half));
    });
    weights.set(half, found);
  }
  return found;
}

/**
 * Moves one corner to where all image gradients around it are orthogonal to the direction towards it.
 *
 * Förstner & Gülch (1987), as in cv::cornerSubPix: q = (Σ g gᵀ)⁻¹ Σ g gᵀ p over the window, Gaussian weights, repeated.
 * @param {Grey} image
 * @param {number} x pixel centres at whole numbers
 * @param {number} y
 * @param {number} half half the window, px: the window is 2·half+1 wide
 * @param {number} [tolerance] px, of the last step
 * @returns {[number, number] | null} null where the window leaves the image or holds no corner
 */
export function refineCorner({ width, height, data }, x, y, half, tolerance = TOLERANCE_PX) {
  const size = 2 * half + 3; // the window and one more pixel all around for the central differences
  const patch = new Float64Array(size * size);
  const gaussian = weightsOf(half);
  let [cx, cy] = [x, y];
  for (let iteration = 0; iteration < MAX_REFINEMENTS; iteration++) {
    const [left, top] = [Math.floor(cx), Math.floor(cy)];
    const [fx, fy] = [cx - left, cy - top];
    const reach = half + 1;
    if (left < reach || top < reach || left + reach + 1 >= width || top + reach + 1 >= height) return null;
    for (let j = 0; j < size; j++) {
      let at = (top - reach + j) * width + left - reach;
      for (let i = 0; i < size; i++, at++) {
        const upper = data[at] + fx * (data[at + 1] - data[at]);
        const lower = data[at + width] + fx * (data[at + width + 1] - data[at + width]);
        patch[j * size + i] = upper + fy * (lower - upper);
      }
    }
    let [a, b, c, u, v] = [0, 0, 0, 0, 0];
    for (let j = -half, n = 0; j <= half; j++) {
      for (let i = -half; i <= half; i++, n++) {
        const at = (j + reach) * size + i + reach;
        const gx = patch[at + 1] - patch[at - 1];
        const gy = patch[at + size] - patch[at - size];
        const weight = gaussian[n];
        const [xx, xy, yy] = [gx * gx * weight, gx * gy * weight, gy * gy * weight];
        a += xx;
        b += xy;
        c += yy;
        u += xx * i + xy * j;
        v += xy * i + yy * j;
      }
    }
    const determinant = a * c - b * b;
    if (determinant <= 1e-9 * (a + c) ** 2) return null; // an edge, or nothing at all
    const [dx, dy] = [(c * u - b * v) / determinant, (a * v - b * u) / determinant];
    cx += dx;
    cy += dy;
    if (Math.abs(cx - x) > half || Math.abs(cy - y) > half) return null;
    if (dx * dx + dy * dy < tolerance * tolerance) break;
  }
  return [cx, cy];
}

/**
 * Length of the shortest side of the squares that touch each corner.
 * @param {number[]} ids @param {number[][]} points @param {number} columns corners in a row of the board
 * @returns {number[]} px; where no neighbour was seen, the median of the others
 */
export function squareSizes(ids, points, columns) {
  const place = new Map(ids.map((id, index) => [id, points[index]]));
  const sizes = ids.map((id, index) => {
    const column = id % columns;
    const neighbours = [id - columns, id + columns];
    if (column > 0) neighbours.push(id - 1);
    if (column < columns - 1) neighbours.push(id + 1);
    return Math.min(
      ...neighbours.map((other) => {
        const point = place.get(other);
        return point ? Math.hypot(point[0] - points[index][0], point[1] - points[index][1]) : Infinity;
      }),
    );
  });
  const known = sizes.filter(Number.isFinite).sort((a, b) => a - b);
  const median = known[known.length >> 1] ?? 0;
  return sizes.map((size) => (Number.isFinite(size) ? size : median));
}

/**
 * Refines all corners of a frame and drops those that cannot be trusted.
 * @param {Grey} image
 * @param {{ids: number[], points: number[][]}} found
 * @param {number} columns corners in a row of the board
 * @returns {{ids: number[], points: number[][]}}
 */
export function refine(image, { ids, points }, columns) {
  const sizes = squareSizes(ids, points, columns);
  /** @type {{ids: number[], points: number[][]}} */
  const kept = { ids: [], points: [] };
  ids.forEach((id, index) => {
    if (sizes[index] < MIN_SQUARE_PX) return;
    const half = Math.min(6, Math.max(2, Math.round(sizes[index] / 8)));
    const [x, y] = points[index];
    const better = refineCorner(image, x, y, half);
    if (!better || Math.hypot(better[0] - x, better[1] - y) > MAX_SHIFT_PX) return;
    kept.ids.push(id);
    kept.points.push(better);
  });
  return kept;
}
