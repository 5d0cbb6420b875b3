import assert from "node:assert/strict";
import { test } from "node:test";
import { fieldOfView, fileName, numbers, verdict } from "../../web/calibrate/result.js";

const CALIBRATION = {
  camera: "HD Pro Webcam C920 (046d:082d)", img_size: [1280, 720], distortion_model: "rectilinear",
  camera_matrix: [[640, 0, 639.5], [0, 640, 359.5], [0, 0, 1]], distortion_coefficients: [-0.25, 0.1, 0, 0, 0],
  avg_reprojection_error: 0.21, uncertainty: { rms: 0.2, max: 0.6 },
};

test("the verdict follows the error at 1280 px width", () => {
  const word = (rms, width) => verdict({ ...CALIBRATION, uncertainty: { rms, max: 3 * rms }, img_size: [width, 720] }).word;
  assert.deepEqual([word(0.1, 1280), word(0.3, 1280), word(0.3, 640), word(3, 1280)], ["Excellent", "Good", "Fair", "Rough"]);
  assert.match(verdict(CALIBRATION).sentence, /0\.2 px off .* 0\.6 px at/);
});

test("90° is 90°", () => {
  assert.ok(Math.abs(fieldOfView(CALIBRATION).horizontal - 90) < 1e-9);
});

test("every coefficient has its name", () => {
  assert.deepEqual(numbers(CALIBRATION).slice(4, 9).map(([name]) => name), ["k1", "k2", "p1", "p2", "k3"]);
  assert.equal(fileName(CALIBRATION), "hd-pro-webcam-c920-046d-082d-1280x720.json");
});
