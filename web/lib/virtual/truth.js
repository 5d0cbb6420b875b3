// Ground truth of the virtual camera, as a calibration.
import { Calibration } from "../../sdk/calibdb.js";
import { intrinsicsOf } from "./lens.js";

/**
 * The calibration that a virtual camera renders with: practice needs no database.
 * @param {import("./camera.js").Setup} setup
 */
export function trueCalibration({ size, lens }) {
  return new Calibration(
    /** @type {import("../../sdk/calibdb.js").CalibrationData} */ ({ img_size: size, ...intrinsicsOf(lens) }),
  );
}
