// Relations of a rig's cameras: how far apart, how much turned, and how sure that is. Pure.
import { homography } from "../lib/homography.js";
import { corners as boardCorners } from "../lib/board.js";
import { composePoses, invertPose } from "../lib/pose.js";
import { lensOf } from "../sdk/projection.js";
import { invert, rigidMotion, rotationVectorOf } from "../sdk/motion.js";

/**
 * @typedef {import("./service.js").Extrinsic} Extrinsic
 * @typedef {import("./service.js").CalibrationData} CalibrationData
 * @typedef {import("../lib/pose.js").Pose} Pose
 *
 * @typedef {object} Relation of a camera to camera 0
 * @property {number} position
 * @property {number} distance in the rig's unit
 * @property {number} distanceStd
 * @property {number} angle degrees
 * @property {number} angleStd degrees
 */

const DEGREES = 180 / Math.PI;

/** @param {Extrinsic} extrinsic @returns {Relation} */
export function relationOf({ position, rvec, tvec, std }) {
  const [distance, angle] = [Math.hypot(...tvec), Math.hypot(...rvec)];
  // Deviation along the vector. The covariances between the axes are not reported.
  const along = (/** @type {number[]} */ vector, /** @type {number} */ length, /** @type {number[]} */ sigma) =>
    length > 0 ? Math.hypot(...vector.map((value, axis) => (value / length) * sigma[axis])) : 0;
  return {
    position,
    distance,
    distanceStd: along(tvec, distance, std.slice(3)),
    angle: angle * DEGREES,
    // A rotation is as uncertain as its three components, whatever its axis.
    angleStd: Math.hypot(...std.slice(0, 3)) * DEGREES,
  };
}

/** Optical centre of a camera in the frame of camera 0. @param {Extrinsic} extrinsic */
export const centreOf = (extrinsic) => invert(rigidMotion(extrinsic)).t;

/**
 * Pose of a board from its corners in a calibrated camera: near enough for a drawing.
 * @param {import("../lib/board-outline.js").Corners} corners px
 * @param {import("../lib/board.js").Board} board
 * @param {CalibrationData} calibration
 * @returns {Pose | null} board → camera, squares; null where the corners do not tell
 */
export function boardPose({ ids, points }, board, calibration) {
  const lens = lensOf(calibration);
  const places = boardCorners(board);
  const rays = points.map((point) => lens.unproject(point));
  const used = ids.map((_, index) => index).filter((index) => (rays[index]?.[2] ?? 0) > 0.05);
  const h = homography(
    used.map((index) => places[ids[index]]),
    used.map((index) => {
      const [x, y, z] = /** @type {number[]} */ (rays[index]);
      return [x / z, y / z];
    }),
  );
  if (!h) return null;
  const [a, b, t] = [0, 1, 2].map((column) => [h[column], h[column + 3], h[column + 6]]);
  const scale = (Math.sign(t[2]) * 2) / (Math.hypot(...a) + Math.hypot(...b));
  const x = unit(a.map((value) => value * scale));
  const z = unit(
    cross(
      x,
      b.map((value) => value * scale),
    ),
  );
  const y = cross(z, x);
  return {
    rvec: rotationVectorOf([x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]]),
    tvec: t.map((value) => value * scale),
  };
}

/**
 * Pose of a board that one camera of a rig has seen.
 * @param {{calibrations: CalibrationData[], extrinsics: Extrinsic[]}} result @param {number} position of the camera
 * @param {import("../lib/board-outline.js").Corners} corners px
 * @param {import("../lib/board.js").Board} board
 * @param {number} square side, in the rig's unit
 * @returns {Pose | null} board → camera 0, in the rig's unit
 */
export function boardInRig({ calibrations, extrinsics }, position, corners, board, square) {
  const pose = boardPose(corners, board, calibrations[position]);
  return (
    pose &&
    composePoses(invertPose(extrinsics[position]), { rvec: pose.rvec, tvec: pose.tvec.map((value) => value * square) })
  );
}

/** @param {number[]} v */
const unit = (v) => v.map((value) => value / Math.hypot(...v));

/** @param {number[]} a @param {number[]} b */
const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];
