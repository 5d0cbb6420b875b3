// Ground truth of the virtual camera, as a calibration.
import { Calibration } from "../../sdk/calibdb.js";

/** The calibration that a virtual camera renders with: practice needs no database. @param {import("./camera.js").Setup} setup */
export function trueCalibration({ size, lens: { fx, fy, cx, cy, k1, k2, p1, p2, k3 } }) {
  return new Calibration(/** @type {import("../../sdk/calibdb.js").CalibrationData} */ ({
    img_size: size, camera_matrix: [[fx, 0, cx], [0, fy, cy], [0, 0, 1]],
    distortion_model: "rectilinear", distortion_coefficients: [k1, k2, p1, p2, k3],
  }));
}
