// Distorter of a rendered scene, so that it lies on the camera's own picture, on the GPU. WebGL2, without dependencies.
//
//     import { Distorter } from "https://<host>/sdk/distorter.js";
//     const distorter = new Distorter(calibration);
//     [scene.width, scene.height] = distorter.img_size; // the scene's canvas, larger than the picture
//     const matrix = distorter.projectionMatrix({ near: 0.1, far: 100 }); // what its camera projects with
//     // once a frame, in the same task in which the scene was rendered:
//     distorter.draw(scene);
//     // distorter.canvas is transparent where the scene is, and lies over the video
//     distorter.dispose();
import { projectionMatrix } from "./pinhole.js";
import { distortingMap, widePinhole } from "./rectification.js";
import { Warp, createCanvas } from "./warp.js";

/**
 * @template {AnyCanvas} [Canvas=HTMLCanvasElement]
 * @typedef {object} Options
 * @property {number} [largest] how many times wider or higher than the picture the scene may be rendered, 2 by default
 * @property {Canvas} [canvas] to draw into; one is made by default
 */
/** @typedef {import("./warp.js").AnyCanvas} AnyCanvas */

/** @template {AnyCanvas} [Canvas=HTMLCanvasElement] */
export class Distorter {
  #warp;
  #pinhole;

  /**
   * @param {import("./rectification.js").Calibration} calibration
   * @param {Options<Canvas>} [options] throws RectifierError where there is no WebGL2
   */
  constructor(calibration, { largest = 2, canvas = createCanvas() } = {}) {
    this.canvas = canvas;
    this.#pinhole = widePinhole(calibration, largest);
    this.#warp = new Warp(canvas, { alpha: true });
    const { camera_matrix: matrix, img_size: extent } = this.#pinhole;
    this.#warp.setMap(() => ({ map: distortingMap(calibration, matrix), size: calibration.img_size, extent }));
  }

  /** Of the scene's picture, px. */
  get img_size() {
    return this.#pinhole.img_size;
  }

  /** Of the scene's picture: a pinhole's. */
  get camera_matrix() {
    return this.#pinhole.camera_matrix;
  }

  /**
   * Projection matrix of the scene's camera.
   * @param {{near?: number, far?: number}} [frustum]
   * @returns {number[]} column-major
   */
  projectionMatrix({ near, far } = {}) {
    return projectionMatrix(this.#pinhole, { near, far });
  }

  /** @param {TexImageSource} scene of `img_size` */
  draw(scene) {
    this.#warp.draw(scene);
  }

  /** Frees what it holds on the GPU. */
  dispose() {
    this.#warp.dispose();
  }
}
