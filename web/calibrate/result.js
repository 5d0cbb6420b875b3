// What came out, in words and numbers.

/** @typedef {import("../sdk/calibdb.js").Calibration} Calibration */

/** Names of the coefficients, in their order. @type {Record<string, string[]>} */
export const COEFFICIENTS = {
  rectilinear: ["k1", "k2", "p1", "p2", "k3"],
  fisheye: ["k1", "k2", "k3", "k4"],
};

/**
 * A verdict for somebody who never heard of reprojection errors.
 * @param {Calibration} calibration
 * @returns {{word: string, sentence: string}}
 */
export function verdict({ uncertainty: { rms, max }, img_size: [width] }) {
  const relative = (rms * 1280) / width;
  const word = relative <= 0.15 ? "Excellent" : relative <= 0.35 ? "Good" : relative <= 1 ? "Fair" : "Rough";
  return {
    word,
    sentence: `Expected to be ${pixels(rms)} off on average over the picture, and ${pixels(max)} at the worst place.`,
  };
}

/** Opening angles across the picture's middle, degrees; of a pinhole with this matrix. @param {Calibration} calibration */
export function fieldOfView({ camera_matrix: [[fx, , cx], [, fy, cy]], img_size: [width, height] }) {
  const degrees = (/** @type {number} */ f, /** @type {number} */ c, /** @type {number} */ side) =>
    ((Math.atan((c + 0.5) / f) + Math.atan((side - 0.5 - c) / f)) * 180) / Math.PI;
  return { horizontal: degrees(fx, cx, width), vertical: degrees(fy, cy, height) };
}

/** Rows of the table of numbers. @param {Calibration} calibration @returns {[name: string, value: string, unit: string][]} */
export function numbers(calibration) {
  const { camera_matrix: [[fx, , cx], [, fy, cy]], distortion_coefficients, distortion_model } = calibration;
  const names = COEFFICIENTS[distortion_model] ?? [];
  return [
    ["fx", fx.toFixed(2), "px"],
    ["fy", fy.toFixed(2), "px"],
    ["cx", cx.toFixed(2), "px"],
    ["cy", cy.toFixed(2), "px"],
    ...distortion_coefficients.map((value, index) =>
      /** @type {[string, string, string]} */ ([names[index] ?? `d${index}`, value.toFixed(5), ""])),
    ["reprojection error", calibration.avg_reprojection_error.toFixed(3), "px rms"],
    ["uncertainty", calibration.uncertainty.rms.toFixed(3), "px rms"],
  ];
}

/** @param {Calibration} calibration @returns {string} a file name without spaces */
export function fileName({ camera, img_size }) {
  const name = camera.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "") || "camera";
  return `${name}-${img_size.join("x")}.json`;
}

/** @param {number} value */
function pixels(value) {
  return `${value < 0.1 ? value.toFixed(2) : value.toFixed(1)} px`;
}
