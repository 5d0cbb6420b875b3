// Disparity of a point: where the patch around it lies in the same row of the other rectified picture.

const HALF_PATCH = 12; // px
const [NEAREST, FARTHEST] = [140, 15]; // px, disparities of the nearest and the farthest point that is looked for
const MIN_CONTRAST = 6; // grey levels, mean absolute deviation of the patch
const MIN_DISTINCTION = 1.5; // difference of the second best place / of the best, from which the best is believed

/**
 * Disparity by the sum of absolute differences, to a fraction of a pixel by a parabola through the best three.
 * @param {ImageData} left
 * @param {ImageData} right rectified pictures
 * @param {readonly [number, number]} pixel of the left one
 * @returns {number | null} px; null: nothing stands out there
 */
export function disparityOf(left, right, [u, v]) {
  const patch = patchAt(left, u, v);
  const mean = patch.reduce((sum, value) => sum + value, 0) / patch.length;
  if (
    differenceOf(
      patch,
      patch.map(() => mean),
    ) < MIN_CONTRAST
  )
    return null;
  const costs = Array.from({ length: NEAREST - FARTHEST + 1 }, (_, step) =>
    differenceOf(patch, patchAt(right, u - FARTHEST - step, v)),
  );
  const best = costs.indexOf(Math.min(...costs));
  const others = costs.filter((_, at) => Math.abs(at - best) > 3);
  if (best === 0 || best === costs.length - 1 || Math.min(...others) < MIN_DISTINCTION * costs[best]) return null;
  const [before, at, after] = costs.slice(best - 1, best + 2);
  return FARTHEST + best + (before - after) / (2 * (before - 2 * at + after));
}

/**
 * Grey levels around a pixel; outside of the picture black.
 * @param {ImageData} picture
 * @param {number} u
 * @param {number} v
 */
function patchAt({ data, width, height }, u, v) {
  const grey = [];
  for (let y = v - HALF_PATCH; y <= v + HALF_PATCH; y++) {
    for (let x = u - HALF_PATCH; x <= u + HALF_PATCH; x++) {
      const inside = x >= 0 && y >= 0 && x < width && y < height;
      grey.push(inside ? data[4 * (y * width + x) + 1] : 0);
    }
  }
  return grey;
}

/** Mean absolute difference. @param {readonly number[]} a @param {readonly number[]} b */
const differenceOf = (a, b) => a.reduce((sum, value, at) => sum + Math.abs(value - b[at]), 0) / a.length;
