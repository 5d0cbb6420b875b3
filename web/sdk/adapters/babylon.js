// A Babylon.js camera that sees as the calibrated one.
//
//     applyCalibration(camera, calibration, { viewport: [canvas.clientWidth, canvas.clientHeight] });
//
// Babylon's camera frame is x right, y up, looking along z: OpenCV's (x, y, z) is at (x, −y, z); in a right-handed
// scene it looks along −z, and that is at (x, −y, −z).
import { projectionMatrix } from "../pinhole.js";

/**
 * @typedef {object} BabylonMatrix
 * @property {(row: number, x: number, y: number, z: number, w: number) => unknown} setRowFromFloats
 *
 * @typedef {object} BabylonCamera what is used of a TargetCamera
 * @property {number} minZ @property {number} maxZ 0: infinitely far
 * @property {() => {useRightHandedSystem: boolean}} getScene
 * @property {() => {useReverseDepthBuffer: boolean, isNDCHalfZRange: boolean}} getEngine
 * @property {() => {clone(): any}} getProjectionMatrix
 * @property {(matrix: any) => void} freezeProjectionMatrix
 */

/**
 * Call it again when the viewport, the calibration, `minZ` or `maxZ` changes; `camera.unfreezeProjectionMatrix()`
 * undoes it.
 * @param {BabylonCamera} camera
 * @param {Parameters<typeof projectionMatrix>[0]} calibration of the rectified picture, or of one that is nearly so
 * @param {Pick<import("../pinhole.js").Frustum, "viewport" | "fit">} [layout] how the picture lies under the scene
 */
export function applyCalibration(camera, calibration, layout) {
  const { useReverseDepthBuffer, isNDCHalfZRange } = camera.getEngine();
  const front = isNDCHalfZRange ? 0 : -1;
  /** @type {[number, number]} */
  const depth = useReverseDepthBuffer ? [1, front] : [front, 1];
  const values = projectionMatrix(calibration, { ...layout, near: camera.minZ, far: camera.maxZ || Infinity, depth });
  const sign = camera.getScene().useRightHandedSystem ? 1 : -1;
  /** @type {BabylonMatrix} */
  const matrix = camera.getProjectionMatrix().clone();
  // Babylon multiplies rows with matrices: its rows are the columns of others.
  for (let row = 0; row < 4; row++) {
    const [x, y, z, w] = values.slice(4 * row, 4 * row + 4).map((value) => (row === 2 ? sign * value : value));
    matrix.setRowFromFloats(row, x, y, z, w);
  }
  camera.freezeProjectionMatrix(matrix);
}
