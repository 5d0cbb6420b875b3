// Relations of a rig's cameras: how far apart, how much turned, and how sure that is. Pure.
import { homography } from "../lib/homography.js";
import { corners as boardCorners, outline } from "../lib/board.js";
import { composePoses, invertPose } from "../lib/pose.js";
import { lensOf } from "../sdk/projection.js";
import { invert, rigidMotion, rotationVectorOf, transform } from "../sdk/motion.js";

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
 *
 * @typedef {{kind: "camera" | "board", position: number, lines: (readonly number[])[][], label: readonly number[] | null}} Body lines: polylines of points
 *   in the frame of camera 0; label: point at which its name stands
 */

const DEGREES = 180 / Math.PI;
const DEPTH = 0.18; // of the scene's size: length of a frustum
const EDGE_STEPS = 6; // of a picture's side: the edges of a wide lens are curved

/** @param {Extrinsic} extrinsic @returns {Relation} */
export function relationOf({ position, rvec, tvec, std }) {
  const [distance, angle] = [Math.hypot(...tvec), Math.hypot(...rvec)];
  // Along the line that leads there; the covariances between the axes are not told.
  const along = (/** @type {number[]} */ vector, /** @type {number} */ length, /** @type {number[]} */ sigma) =>
    (length > 0 ? Math.hypot(...vector.map((value, axis) => (value / length) * sigma[axis])) : 0);
  return {
    position, distance, distanceStd: along(tvec, distance, std.slice(3)), angle: angle * DEGREES,
    // A rotation is as unsure as its three components, whatever its axis is.
    angleStd: Math.hypot(...std.slice(0, 3)) * DEGREES,
  };
}

/** Optical centre of a camera in the frame of camera 0. @param {Extrinsic} extrinsic */
export const centreOf = (extrinsic) => invert(rigidMotion(extrinsic)).t;

/**
 * Pose of a board from its corners in a calibrated camera: near enough for a drawing.
 * @param {import("../lib/board-outline.js").Corners} corners px @param {import("../lib/board.js").Board} board @param {CalibrationData} calibration
 * @returns {Pose | null} board → camera, squares; null where the corners do not tell
 */
export function boardPose({ ids, points }, board, calibration) {
  const lens = lensOf(calibration);
  const places = boardCorners(board);
  const rays = points.map((point) => lens.unproject(point));
  const used = ids.map((_, index) => index).filter((index) => (rays[index]?.[2] ?? 0) > 0.05);
  const h = homography(used.map((index) => places[ids[index]]), used.map((index) => {
    const [x, y, z] = /** @type {number[]} */ (rays[index]);
    return [x / z, y / z];
  }));
  if (!h) return null;
  const [a, b, t] = [0, 1, 2].map((column) => [h[column], h[column + 3], h[column + 6]]);
  const scale = (Math.sign(t[2]) * 2) / (Math.hypot(...a) + Math.hypot(...b));
  const x = unit(a.map((value) => value * scale));
  const z = unit(cross(x, b.map((value) => value * scale)));
  const y = cross(z, x);
  return { rvec: rotationVectorOf([x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]]), tvec: t.map((value) => value * scale) };
}

/**
 * Pose of a board that one camera of a rig has seen.
 * @param {{calibrations: CalibrationData[], extrinsics: Extrinsic[]}} result @param {number} position of the camera
 * @param {import("../lib/board-outline.js").Corners} corners px @param {import("../lib/board.js").Board} board @param {number} square side, in the rig's unit
 * @returns {Pose | null} board → camera 0, in the rig's unit
 */
export function boardInRig({ calibrations, extrinsics }, position, corners, board, square) {
  const pose = boardPose(corners, board, calibrations[position]);
  return pose && composePoses(invertPose(extrinsics[position]), { rvec: pose.rvec, tvec: pose.tvec.map((value) => value * square) });
}

/** @param {number[]} v */
const unit = (v) => v.map((value) => value / Math.hypot(...v));

/** @param {number[]} a @param {number[]} b */
const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];

/**
 * Bodies of the 3D view: frusta of the cameras, and boards.
 * @param {{calibrations: CalibrationData[], extrinsics: Extrinsic[]}} result
 * @param {readonly Pose[]} boards board → camera 0, in the rig's unit @param {import("../lib/board.js").Board} board @param {number} square side, in the rig's unit
 * @returns {{bodies: Body[], middle: number[], radius: number}} middle and radius of a sphere around them
 */
export function sceneOf({ calibrations, extrinsics }, boards, board, square) {
  const centres = extrinsics.map(centreOf);
  const edge = outline(board).map(([x, y]) => [x * square, y * square, 0]);
  const sheets = boards.map((pose) => edge.map((point) => transform(rigidMotion(pose), point)));
  const extent = extentOf([...centres, ...sheets.flat()]);
  const depth = DEPTH * 2 * (extent.radius || 1);
  const cameras = extrinsics.map((extrinsic, index) => frustum(calibrations[index], extrinsic, depth));
  const bodies = /** @type {Body[]} */ ([
    ...sheets.map((sheet, index) => ({ kind: /** @type {const} */ ("board"), position: index, lines: [[...sheet, sheet[0]]], label: null })),
    ...cameras,
  ]);
  return { bodies, ...extentOf(bodies.flatMap(({ lines }) => lines.flat())) };
}

/** @param {CalibrationData} calibration @param {Extrinsic} extrinsic @param {number} depth @returns {Body} */
function frustum(calibration, extrinsic, depth) {
  const { img_size: [width, height], camera_matrix: [[fx, , cx], [, fy, cy]] } = calibration;
  const lens = lensOf(calibration);
  const back = invert(rigidMotion(extrinsic));
  const at = (/** @type {number} */ u, /** @type {number} */ v) => {
    const ray = lens.unproject([u, v]) ?? [(u - cx) / fx, (v - cy) / fy, 1];
    const length = Math.hypot(...ray);
    return transform(back, ray.map((value) => (value * depth) / length));
  };
  const [right, bottom] = [width - 0.5, height - 0.5];
  const vertices = [[-0.5, -0.5], [right, -0.5], [right, bottom], [-0.5, bottom]];
  const rim = vertices.flatMap(([u, v], index) => {
    const [u1, v1] = vertices[(index + 1) % 4];
    return Array.from({ length: EDGE_STEPS }, (_, step) => at(u + ((u1 - u) * step) / EDGE_STEPS, v + ((v1 - v) * step) / EDGE_STEPS));
  });
  const rays = vertices.map(([u, v]) => [back.t, at(u, v)]);
  return { kind: "camera", position: extrinsic.position, lines: [[...rim, rim[0]], ...rays], label: back.t };
}

/** @param {(readonly number[])[]} points */
function extentOf(points) {
  const bounds = [0, 1, 2].map((axis) => {
    const values = points.map((point) => point[axis]);
    return [Math.min(...values), Math.max(...values)];
  });
  const middle = bounds.map(([low, high]) => (low + high) / 2);
  return { middle, radius: Math.max(1e-9, ...points.map((point) => Math.hypot(...point.map((value, axis) => value - middle[axis])))) };
}

/**
 * Place of a point in the drawing, looked at from a direction.
 * @param {readonly number[]} point @param {{middle: number[], radius: number}} scene @param {number} yaw rad @param {number} pitch rad
 * @returns {[number, number, number]} x right and y down, -1 to 1; depth
 */
export function drawnPoint(point, { middle, radius }, yaw, pitch) {
  const [x, y, z] = point.map((value, axis) => (value - middle[axis]) / radius);
  const [cosYaw, sinYaw, cosPitch, sinPitch] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
  const [u, w] = [cosYaw * x + sinYaw * z, -sinYaw * x + cosYaw * z];
  return [u, cosPitch * y - sinPitch * w, sinPitch * y + cosPitch * w];
}
