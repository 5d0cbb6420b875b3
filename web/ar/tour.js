// A tour of poses for the virtual camera's board: it fills the picture, goes to a side, and farther away.
import { rotationMatrix } from "../lib/pose.js";
import { focalLengths } from "../sdk/pinhole.js";

/**
 * Turned by degrees; its middle at so many times the distance from the axis; so far away, in squares for a lens of 0.8
 * widths.
 */
const STOPS = [
  { turn: [-25, 12, 3], aside: [0.02, -0.01], distance: 6.8 },
  { turn: [-35, -20, 0], aside: [-0.25, -0.1], distance: 6 },
  { turn: [-40, 25, 10], aside: [0.15, 0], distance: 10 },
  { turn: [0, 0, 0], aside: [0, 0], distance: 5.3 },
];

/**
 * @param {import("../lib/board.js").Board} board @param {import("../sdk/rectification.js").Calibration} calibration
 * @param {number} stop any whole number
 * @returns {import("../lib/pose.js").Pose} board → camera, squares
 */
export function stopAt({ squares: [columns, rows] }, calibration, stop) {
  const {
    img_size: [width],
  } = calibration;
  const [fx] = focalLengths(calibration);
  const { turn, aside, distance } = STOPS[stop % STOPS.length];
  const rvec = turn.map((degrees) => (degrees * Math.PI) / 180);
  const [a, b, , d, e, , g, h] = rotationMatrix(rvec);
  const z = (distance * Math.max(columns / 9, rows / 6) * fx) / (0.8 * width);
  const [x, y] = [columns / 2, rows / 2];
  return { rvec, tvec: [aside[0] * z - a * x - b * y, aside[1] * z - d * x - e * y, z - g * x - h * y] };
}
