// Pose of the board from its corners in a picture: by a homography through the lens, then by least squares in pixels.
import { homography } from "./homography.js";
import { minimize } from "./least-squares.js";
import { rotationMatrix, rotationVectorOf } from "./pose.js";

/**
 * @import { Lens } from "../sdk/projection.js"
 * @import { Pose } from "./pose.js"
 */

const MIN_CORNERS = 6; // corners
const MIN_COSINE = 0.05; // cosine of the largest angle from the axis that the homography is made from, 87°
const UNSEEN_RESIDUAL_PX = 1e3; // px; how far off a corner counts that the lens would not see

/**
 * The pose in which this lens sees the points nearest to their pixels.
 * @param {Lens} lens
 * @param {readonly (readonly number[])[]} points x and y on the board
 * @param {readonly (readonly number[])[]} pixels
 * @returns {Pose | null} board → camera, in the points' unit; null where there are too few to tell
 */
export function poseOf(lens, points, pixels) {
  if (points.length < MIN_CORNERS) return null;
  /** @type {number[][][]} */
  const pairs = pixels.flatMap((pixel, index) => {
    const ray = lens.unproject(pixel);
    return ray && ray[2] > MIN_COSINE ? [[[...points[index]], [ray[0] / ray[2], ray[1] / ray[2]]]] : [];
  });
  const h = homography(
    pairs.map(([from]) => from),
    pairs.map(([, to]) => to),
  );
  if (!h) return null;
  /** @param {number[]} at */
  const residuals = ([a, b, c, ...tvec]) => {
    const place = rigidTransform({ rvec: [a, b, c], tvec });
    return points.flatMap(([x, y], index) => {
      const [u, v] = lens.project(place([x, y, 0])) ?? [UNSEEN_RESIDUAL_PX, UNSEEN_RESIDUAL_PX];
      return [u - pixels[index][0], v - pixels[index][1]];
    });
  };
  const { rvec, tvec } = decomposeHomography(h);
  const at = minimize(residuals, [...rvec, ...tvec]);
  return { rvec: at.slice(0, 3), tvec: at.slice(3) };
}

/**
 * Board → camera, for many points.
 * @param {Pose} pose
 * @returns {(point: readonly number[]) => [number, number, number]}
 */
export function rigidTransform({ rvec, tvec: [tx, ty, tz] }) {
  const [a, b, c, d, e, f, g, h, i] = rotationMatrix(rvec);
  return ([x, y, z]) => [a * x + b * y + c * z + tx, d * x + e * y + f * z + ty, g * x + h * y + i * z + tz];
}

/**
 * The pose whose [r1 r2 t] a homography onto the plane z = 1 is, nearly.
 * @param {number[]} h row-major 3x3
 * @returns {Pose}
 */
function decomposeHomography([a, b, tx, d, e, ty, g, h, tz]) {
  const scale = (Math.sign(tz) * 2) / (Math.hypot(a, d, g) + Math.hypot(b, e, h));
  const x = unit([a, d, g].map((value) => value * scale));
  const along = [b, e, h].map((value) => value * scale);
  const share = x[0] * along[0] + x[1] * along[1] + x[2] * along[2];
  const y = unit(along.map((value, axis) => value - share * x[axis]));
  const z = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
  return {
    rvec: rotationVectorOf([x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]]),
    tvec: [tx, ty, tz].map((value) => value * scale),
  };
}

/** Of length 1. @param {number[]} vector */
export function unit(vector) {
  const length = Math.hypot(...vector);
  return vector.map((value) => value / length);
}
