// Modes of drawing over a camera's picture: with the camera matrix only, over the straightened picture, and over the
// picture as it is with the drawing distorted. Each returns where it shows a pixel of the camera, and where it draws
// a point.
import { axialMatrix } from "../sdk/pinhole.js";
import { lensOf } from "../sdk/projection.js";
import { Distorter } from "../sdk/distorter.js";
import { Rectifier } from "../sdk/rectifier.js";

/**
 * @import { Pinhole } from "../sdk/pinhole.js"
 * @import { Calibration } from "../sdk/rectification.js"
 */

/**
 * @typedef {object} Mode
 * @property {import("../sdk/projection.js").Lens} lens what the board's pose is found with
 * @property {() => Pinhole} pinhole what the scene is rendered with
 * @property {HTMLCanvasElement | null} picture that is shown; null: the camera's own
 * @property {HTMLCanvasElement | null} overlay that is shown; null: the scene's own
 * @property {(pixel: readonly number[]) => readonly number[] | null} seen where a pixel of the camera is in what is
 *   shown
 * @property {(point: readonly number[]) => readonly number[] | null} drawn where a point is, camera frame
 * @property {(frame: HTMLCanvasElement, scene: HTMLCanvasElement) => void} show
 * @property {() => void} dispose
 */

/**
 * By their names, in the order of the keys 1, 2, 3, 4. `estimate` takes an estimate instead of a calibration.
 * @type {Record<string, (calibration: Calibration) => Mode & {balance?: (value: number) => void}>}
 */
export const MODES = { matrix, rectified, distorted, estimate: distorted };

/** @param {number[][]} camera_matrix */
const undistorted = (camera_matrix) =>
  lensOf({ camera_matrix, distortion_model: "rectilinear", distortion_coefficients: [0, 0, 0, 0, 0] });

/** Mode of an application that ignores distortion. @param {Calibration} calibration @returns {Mode} */
function matrix(calibration) {
  const lens = undistorted(axialMatrix(calibration));
  return {
    lens,
    pinhole: () => calibration,
    picture: null,
    overlay: null,
    seen: (pixel) => pixel,
    drawn: lens.project,
    show() {},
    dispose() {},
  };
}

/**
 * @param {Calibration} calibration
 * @returns {Mode & {balance: (value: number) => void}} balance: how much of the edge is kept, 0…1
 */
function rectified(calibration) {
  const lens = lensOf(calibration);
  const canvas = document.createElement("canvas");
  const rectifier = new Rectifier(calibration, { canvas });
  let straight = undistorted(rectifier.camera_matrix);
  return {
    lens,
    pinhole: () => rectifier,
    picture: canvas,
    overlay: null,
    drawn: (point) => straight.project(point),
    seen(pixel) {
      const ray = lens.unproject(pixel);
      return ray && straight.project(ray);
    },
    balance(value) {
      rectifier.balance(value);
      straight = undistorted(rectifier.camera_matrix);
    },
    show: (frame) => rectifier.draw(frame),
    dispose: () => rectifier.dispose(),
  };
}

/** @param {Calibration} calibration @returns {Mode} */
function distorted(calibration) {
  const lens = lensOf(calibration);
  const canvas = document.createElement("canvas");
  const distorter = new Distorter(calibration, { canvas });
  return {
    lens,
    pinhole: () => distorter,
    picture: null,
    overlay: canvas,
    seen: (pixel) => pixel,
    drawn: lens.project,
    show: (_, scene) => distorter.draw(scene),
    dispose: () => distorter.dispose(),
  };
}
