// Views of several eyes, as WebXR has them: a projection matrix and a transform each, and the camera that each eye is.
import { projectionMatrix } from "./pinhole.js";
import { invert, quaternionOf } from "./motion.js";

/**
 * @typedef {import("./pinhole.js").Frustum} Frustum
 * @typedef {import("./pinhole.js").Pinhole} Pinhole
 * @typedef {import("./motion.js").RigidMotion} RigidMotion
 * @typedef {"left" | "right" | "none"} Eye as XREye
 *
 * @typedef {object} Transform as XRRigidTransform
 * @property {Float32Array} matrix 4x4, column-major
 * @property {{x: number, y: number, z: number, w: number}} position
 * @property {{x: number, y: number, z: number, w: number}} orientation
 * @property {{matrix: Float32Array}} inverse
 *
 * @typedef {object} View as XRView with the attributes of webxr/extension.js
 * @property {Eye} eye
 * @property {Float32Array} projectionMatrix column-major
 * @property {Transform} transform the eye, looking along −z with y up → world
 * @property {Float32Array} cameraMatrix column-major 3x3
 * @property {Float32Array} distortionCoefficients
 * @property {string} distortionModel
 *
 * @typedef {object} Camera what an eye sees through
 * @property {Eye} eye
 * @property {Pinhole & Partial<import("./projection.js").Intrinsics>} pinhole a calibration, or a pinhole without
 *   distortion
 * @property {RigidMotion} motion reference camera → this one, both as OpenCV has them: x right, y down, z forward
 *
 * @typedef {Frustum & {pose?: ArrayLike<number>}} ViewOptions pose: reference camera, looking along −z with y up →
 *   world, column-major; the identity by default
 */

const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
const FLIP = [1, -1, -1]; // of OpenCV's axes to those of a scene

/** @param {readonly Camera[]} cameras @param {ViewOptions} [options] @returns {View[]} */
export function createViews(cameras, { pose = IDENTITY, ...frustum } = {}) {
  return cameras.map(({ eye, pinhole, motion }) => ({
    eye,
    projectionMatrix: Float32Array.from(projectionMatrix(pinhole, frustum)),
    transform: transformOf(product(pose, sceneMatrix(invert(motion)))),
    ...viewAttributes(pinhole),
  }));
}

/**
 * Attributes by which a view describes its camera, in new arrays: a write into them does not change other views.
 * @param {{camera_matrix: readonly (readonly number[])[], distortion_coefficients?: readonly number[],
 *   distortion_model?: string}} camera without distortion by default
 */
export function viewAttributes({
  camera_matrix: k,
  distortion_coefficients = [0, 0, 0, 0, 0],
  distortion_model = "rectilinear",
}) {
  return {
    cameraMatrix: Float32Array.from([0, 1, 2].flatMap((column) => k.map((row) => row[column]))),
    distortionCoefficients: Float32Array.from(distortion_coefficients),
    distortionModel: distortion_model,
  };
}

/**
 * Motion between OpenCV's frames as one between those of a scene.
 * @param {RigidMotion} motion
 * @returns {number[]} 4x4, column-major
 */
function sceneMatrix({ r, t }) {
  const columns = [0, 1, 2].flatMap((column) => [
    ...FLIP.map((sign, row) => sign * FLIP[column] * r[3 * row + column]),
    0,
  ]);
  return [...columns, ...FLIP.map((sign, row) => sign * t[row]), 1];
}

/** @param {ArrayLike<number>} a @param {ArrayLike<number>} b 4x4, column-major @returns {number[]} */
function product(a, b) {
  return IDENTITY.map((_, at) => [0, 1, 2, 3].reduce((sum, k) => sum + a[4 * k + (at % 4)] * b[4 * (at >> 2) + k], 0));
}

/** @param {readonly number[]} m 4x4, column-major @returns {Transform} */
function transformOf(m) {
  const r = [m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]];
  const [w, x, y, z] = quaternionOf(r);
  const back = invert({ r, t: m.slice(12, 15) });
  const columns = [0, 1, 2].flatMap((column) => [back.r[column], back.r[column + 3], back.r[column + 6], 0]);
  return {
    matrix: Float32Array.from(m),
    position: { x: m[12], y: m[13], z: m[14], w: 1 },
    orientation: { x, y, z, w },
    inverse: { matrix: Float32Array.from([...columns, ...back.t, 1]) },
  };
}
