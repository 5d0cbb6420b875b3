// An A-Frame camera that sees as the calibrated one: a component next to `camera`.
//
//     registerCalibrated(AFRAME);
//     <a-entity id="eye" camera="near: 0.01" calibrated="fit: cover" position="0 0 0"></a-entity>
//     document.querySelector("#eye").components.calibrated.use(calibration);
//
// The scene's camera frame is three.js' own: OpenCV's (x, y, z) is at (x, −y, −z).
import { applyCalibration } from "./three.js";

/**
 * @typedef {object} Component what A-Frame gives a component
 * @property {any} el @property {{fit: import("../pinhole.js").Fit}} data
 * @property {Parameters<typeof applyCalibration>[1] | null} calibration
 * @property {() => void} apply
 */

/** @param {{registerComponent(name: string, definition: object): unknown}} aframe @param {string} [name] */
export function registerCalibrated(aframe, name = "calibrated") {
  aframe.registerComponent(name, {
    dependencies: ["camera"],
    schema: { fit: { default: "cover" } },
    calibration: null,
    /** @this {Component} */
    init() {
      this.apply = this.apply.bind(this);
      this.el.sceneEl.addEventListener("rendererresize", this.apply);
    },
    /** @this {Component} */
    update() {
      this.apply();
    },
    /** @this {Component} */
    remove() {
      this.el.sceneEl.removeEventListener("rendererresize", this.apply);
    },
    /** @this {Component} @param {Component["calibration"]} calibration */
    use(calibration) {
      this.calibration = calibration;
      this.apply();
    },
    /** @this {Component} */
    apply() {
      const {
        calibration,
        data: { fit },
        el: { sceneEl },
      } = this;
      const camera = this.el.getObject3D("camera");
      if (!calibration || !camera) return;
      const { clientWidth, clientHeight } = sceneEl.canvas;
      applyCalibration(camera, calibration, { viewport: [clientWidth, clientHeight], fit });
    },
  });
}
