// Misalignment of the drawing: distance between drawn and detected corners.
import { rigidTransform } from "./pose.js";

/**
 * @param {Pick<import("./modes.js").Mode, "seen" | "drawn">} mode
 * @param {import("../lib/pose.js").Pose} pose
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
