// Misalignment of the drawing: distance between drawn and detected corners, or between two drawings of one house.
import { rigidTransform } from "../lib/board-pose.js";

/** @import { Pose } from "../lib/pose.js" */

/**
 * @param {Pick<import("./modes.js").Mode, "seen" | "drawn">} mode
 * @param {Pose} pose
 * @param {readonly (readonly number[])[]} points on the board
 * @param {readonly (readonly number[])[]} pixels of the camera
 * @param {readonly [number, number]} size of the camera's picture, px
 * @returns {{rms: number, outermost: number} | null} px of what is shown: over all points, and of the one nearest to a
 *   corner of the camera's picture
 */
export function misalignment(mode, pose, points, pixels, [width, height]) {
  const place = rigidTransform(pose);
  let [sum, count, outermost, nearest] = [0, 0, 0, Infinity];
  pixels.forEach((pixel, index) => {
    const [seen, drawn] = [mode.seen(pixel), mode.drawn(place([...points[index], 0]))];
    if (!seen || !drawn) return;
    const off = Math.hypot(drawn[0] - seen[0], drawn[1] - seen[1]);
    sum += off * off;
    count += 1;
    const away = Math.hypot(Math.min(pixel[0], width - 1 - pixel[0]), Math.min(pixel[1], height - 1 - pixel[1]));
    if (away < nearest) [nearest, outermost] = [away, off];
  });
  return count > 0 ? { rms: Math.sqrt(sum / count), outermost } : null;
}

/**
 * Distance between two drawings of the same points.
 * @typedef {{lens: import("../sdk/projection.js").Lens, pose: Pose}} Drawing
 * @param {Drawing} one @param {Drawing} other @param {readonly (readonly number[])[]} points in the board's frame
 * @returns {{rms: number, outermost: number} | null} px: over all points, and the largest
 */
export function difference(one, other, points) {
  const [place, otherPlace] = [rigidTransform(one.pose), rigidTransform(other.pose)];
  const distances = points.flatMap((point) => {
    const [a, b] = [one.lens.project(place(point)), other.lens.project(otherPlace(point))];
    return a && b ? [Math.hypot(a[0] - b[0], a[1] - b[1])] : [];
  });
  if (!distances.length) return null;
  const squares = distances.reduce((sum, each) => sum + each * each, 0);
  return { rms: Math.sqrt(squares / distances.length), outermost: Math.max(...distances) };
}
