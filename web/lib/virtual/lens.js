// Lens of the virtual camera: OpenCV's rectilinear model, its parameters by their names.
import { lensOf } from "../../sdk/projection.js";

/**
 * @typedef {object} LensParameters
 * @property {number} fx px
 * @property {number} fy
 * @property {number} cx px, centre of the top-left pixel is 0
 * @property {number} cy
 * @property {number} k1
 * @property {number} k2
 * @property {number} p1
 * @property {number} p2
 * @property {number} k3
 */

/** Intrinsics with these parameters, as of a calibration. @param {LensParameters} lens */
export const intrinsicsOf = ({ fx, fy, cx, cy, k1, k2, p1, p2, k3 }) => ({
  camera_matrix: [
    [fx, 0, cx],
    [0, fy, cy],
    [0, 0, 1],
  ],
  distortion_model: "rectilinear",
  distortion_coefficients: [k1, k2, p1, p2, k3],
});

/** Projection of a lens with these parameters. @param {LensParameters} lens */
export const projectionOf = (lens) => lensOf(intrinsicsOf(lens));
