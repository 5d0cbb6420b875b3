// A three.js camera that sees as the calibrated one.
//
//     applyCalibration(camera, calibration, { viewport: [canvas.clientWidth, canvas.clientHeight] });
//
// The scene's camera frame is three.js' own, x right, y up, looking along −z: OpenCV's (x, y, z) is at (x, −y, −z).
import { projectionMatrix } from "../pinhole.js";

/**
 * @typedef {object} ThreeCamera what is used of a PerspectiveCamera
 * @property {number} near @property {number} far
 * @property {number} coordinateSystem whose depth it has, WebGL's or WebGPU's
 * @property {boolean} [reversedDepth]
 * @property {{fromArray(values: number[]): unknown}} projectionMatrix
 * @property {{copy(matrix: any): {invert(): unknown}}} projectionMatrixInverse
 * @property {() => void} updateProjectionMatrix
 */

const WEBGPU = 2001; // THREE.WebGPUCoordinateSystem

/**
 * Call it again when the viewport or the calibration changes. `near` and `far` are the camera's: after a change, call
 * `camera.updateProjectionMatrix()` as usual. Field of view and aspect have no effect any more.
 * @param {ThreeCamera} camera
 * @param {Parameters<typeof projectionMatrix>[0]} calibration of the rectified picture, or of one that is nearly so
 * @param {Pick<import("../pinhole.js").Frustum, "viewport" | "fit">} [layout] how the picture lies under the scene
 */
export function applyCalibration(camera, calibration, layout) {
  camera.updateProjectionMatrix = () => {
    const { near, far, coordinateSystem, reversedDepth } = camera;
    /** @type {[number, number]} */
    const depth = reversedDepth ? [1, 0] : [coordinateSystem === WEBGPU ? 0 : -1, 1];
    camera.projectionMatrix.fromArray(projectionMatrix(calibration, { ...layout, near, far, depth }));
    camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();
  };
  camera.updateProjectionMatrix();
}
