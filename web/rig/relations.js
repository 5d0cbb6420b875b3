// Relations of a rig's cameras: how far apart, how much turned, and how sure that is. Pure.
import { corners as boardCorners } from "../lib/board.js";
import { poseOf } from "../lib/board-pose.js";
import { composePoses, invertPose } from "../lib/pose.js";
import { lensOf } from "../sdk/projection.js";

/**
 * @import { Pose } from "../lib/pose.js"
 * @import { CalibrationData, Extrinsic } from "./service.js"
 */

/**
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

/**
 * Pose of a board that one camera of a rig has seen.
 * @param {{calibrations: CalibrationData[], extrinsics: Extrinsic[]}} result @param {number} position of the camera
 * @param {import("../lib/board-outline.js").Corners} corners px
 * @param {import("../lib/board.js").Board} board
 * @param {number} square side, in the rig's unit
 * @returns {Pose | null} board → camera 0, in the rig's unit
 */
export function boardInRig({ calibrations, extrinsics }, position, corners, board, square) {
  const places = boardCorners(board);
  const pose = poseOf(
    lensOf(calibrations[position]),
    corners.ids.map((id) => places[id]),
    corners.points,
  );
  return (
    pose &&
    composePoses(invertPose(extrinsics[position]), { rvec: pose.rvec, tvec: pose.tvec.map((value) => value * square) })
  );
}
