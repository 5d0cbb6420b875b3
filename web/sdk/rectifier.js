// Rectifier of a camera's picture on the GPU. WebGL2, without dependencies.
//
//     import { Rectifier } from "https://<host>/sdk/rectifier.js";
//     const rectifier = new Rectifier(calibration, { balance: 0 });
//     document.body.append(rectifier.canvas);
//     rectifier.draw(video); // once a frame
//     rectifier.camera_matrix; // of the picture it draws, which has no distortion
//     rectifier.dispose();
import { projectionMatrix, scalePinhole } from "./pinhole.js";
import { rectifiedMatrix, rectifyingMap } from "./rectification.js";
import { Warp, createCanvas } from "./warp.js";

export { rectifiedMatrix, rectifyingMap } from "./rectification.js";
export { RectifierError } from "./warp.js";

/**
 * @template {AnyCanvas} [Canvas=HTMLCanvasElement]
 * @typedef {object} Options
 * @property {number} [balance] 0: only what is picture everywhere; 1: all of the picture, with black edges
 * @property {number} [zoom] how much larger than that, 1 by default
 * @property {number} [scale] of the picture drawn to the camera's, 1 by default: a half costs a quarter
 * @property {Canvas} [canvas] to draw into; one is made by default
 */
/** @typedef {import("./warp.js").AnyCanvas} AnyCanvas */
/** @typedef {import("./rectification.js").Calibration} Calibration */

/** @template {AnyCanvas} [Canvas=HTMLCanvasElement] */
export class Rectifier {
  #calibration;
  #scale;
  #warp;
  #pinhole;

  /**
   * @param {Calibration} calibration
   * @param {Options<Canvas>} [options] throws RectifierError where there is no WebGL2
   */
  constructor(calibration, { balance = 0, zoom = 1, scale = 1, canvas = createCanvas() } = {}) {
    this.canvas = canvas;
    this.#calibration = calibration;
    this.#scale = scale;
    this.#warp = new Warp(canvas, { alpha: false });
    this.#pinhole = this.#straighten(balance, zoom);
  }

  /** Camera matrix of the picture drawn: a pinhole's, without distortion. */
  get camera_matrix() {
    return this.#pinhole.camera_matrix;
  }

  /** Of the picture drawn, px. */
  get img_size() {
    return this.#pinhole.img_size;
  }

  /**
   * For a scene over the picture drawn.
   * @param {import("./pinhole.js").Frustum} [frustum]
   * @returns {number[]} column-major
   */
  projectionMatrix(frustum) {
    return projectionMatrix(this.#pinhole, frustum);
  }

  /** Set the share of the picture's edge to keep, and the zoom. @param {number} value 0…1 @param {number} [zoom] */
  balance(value, zoom = 1) {
    this.#pinhole = this.#straighten(value, zoom);
  }

  /** @param {TexImageSource} picture of the calibration's size */
  draw(picture) {
    this.#warp.draw(picture);
  }

  /** Frees what it holds on the GPU: browsers give a page few contexts. */
  dispose() {
    this.#warp.dispose();
  }

  /** @param {number} balance @param {number} zoom */
  #straighten(balance, zoom) {
    const { img_size: extent } = this.#calibration;
    const whole = { img_size: extent, camera_matrix: rectifiedMatrix(this.#calibration, balance, zoom) };
    const pinhole = scalePinhole(whole, this.#scale);
    const { camera_matrix: matrix, img_size: size } = pinhole;
    this.#warp.setMap(() => ({ map: rectifyingMap(this.#calibration, matrix, size), size, extent }));
    return pinhole;
  }
}
