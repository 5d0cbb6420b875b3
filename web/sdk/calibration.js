// A camera's calibration and what can be done with it.
import { lensOf } from "./projection.js";

/**
 * @typedef {object} Adapted
 * @property {[number, number]} img_size
 * @property {number} zoom
 * @property {number[][]} camera_matrix
 * @property {number[]} distortion_coefficients
 * @property {boolean} interpolated between two calibrated zooms
 *
 * @typedef {object} CalibrationData as the service answers it, and as its files hold it
 * @property {[number, number]} img_size
 * @property {number[][]} camera_matrix row-major 3x3, px; the centre of the top-left pixel is (0, 0)
 * @property {number[]} distortion_coefficients in the order that the model's name says
 * @property {string} distortion_model "rectilinear" (k1 k2 p1 p2 k3), "fisheye" (k1 k2 k3 k4), …
 * @property {number} avg_reprojection_error rms over all measurements, px
 * @property {string | null} id
 * @property {string} camera
 * @property {string} platform
 * @property {number} zoom
 * @property {"consensus" | "checked" | null} [basis] what makes it reliable
 * @property {number | null} [spread] px rms between the calibrations that agree, over the image
 * @property {number | null} [held_out_error] px rms of views under a fit that did not see them
 * @property {"scale" | "crop" | "scale+crop" | "neither" | null} [relation] of this size to the one asked for, where verified
 * @property {Adapted | null} [adapted] parameters for the size or zoom asked for, where verified
 * @property {number} calibrations how many agree on this
 * @property {number} contributors
 * @property {boolean} reliable
 * @property {boolean} exact_size false: the closest known size, not the one asked for
 * @property {{rms: number, max: number}} uncertainty predicted projection error over the image, px
 * @property {number} calibration_time unix seconds
 *
 * @typedef {"cover" | "contain" | "fill" | "none" | "scale-down"} Fit CSS `object-fit`, centred
 *
 * @typedef {object} Frustum
 * @property {number} [near] @property {number} [far] in the scene's unit; Infinity is a number too
 * @property {readonly [number, number]} [viewport] what is drawn into, px of any kind; the picture's size unless told
 * @property {Fit} [fit] how the picture lies in it; "cover" unless told
 * @property {readonly [number, number]} [depth] what `near` and `far` become; [-1, 1] as in WebGL unless told, [0, 1] in WebGPU
 *
 * @typedef {object} OpenCV
 * @property {[number, number]} imageSize
 * @property {number[]} cameraMatrix 3x3, row by row
 * @property {number[]} distCoeffs
 * @property {"" | "fisheye" | "omnidir"} module of `cv` whose functions take them
 * @property {number} [xi] what `omnidir` takes besides
 */

/** Its data, unchanged, with functions. */
export class Calibration {
  /** @type {ReturnType<typeof lensOf> | undefined} */
  #lens;

  /** @param {CalibrationData} data */
  constructor(data) {
    this.img_size = data.img_size;
    this.camera_matrix = data.camera_matrix;
    this.distortion_coefficients = data.distortion_coefficients;
    this.distortion_model = data.distortion_model;
    this.avg_reprojection_error = data.avg_reprojection_error;
    this.id = data.id;
    this.camera = data.camera;
    this.platform = data.platform;
    this.zoom = data.zoom;
    this.basis = data.basis;
    this.spread = data.spread;
    this.held_out_error = data.held_out_error;
    this.relation = data.relation;
    this.adapted = data.adapted;
    this.calibrations = data.calibrations;
    this.contributors = data.contributors;
    this.reliable = data.reliable;
    this.exact_size = data.exact_size;
    this.uncertainty = data.uncertainty;
    this.calibration_time = data.calibration_time;
    Object.assign(this, data); // what a later service tells besides
  }

  get #optics() {
    return (this.#lens ??= lensOf(this));
  }

  /** @param {readonly number[]} point camera frame, x right, y down, z forward @returns {[number, number] | null} px */
  project(point) {
    return this.#optics.project(point);
  }

  /** @param {readonly number[]} pixel @returns {[number, number, number] | null} unit ray */
  unproject(pixel) {
    return this.#optics.unproject(pixel);
  }

  /** For a scene over the picture, which must be rectified or nearly without distortion. @param {Frustum} [frustum] */
  projectionMatrix(frustum) {
    return projectionMatrix(this, frustum);
  }

  /** @returns {OpenCV} for `cv.matFromArray(3, 3, cv.CV_64F, cameraMatrix)` and the like */
  toOpenCV() {
    const [xi, ...rest] = this.distortion_coefficients;
    /** @type {Pick<OpenCV, "imageSize" | "cameraMatrix">} */
    const pinhole = { imageSize: this.img_size, cameraMatrix: this.camera_matrix.flat() };
    if (this.distortion_model === "omnidirectional") return { ...pinhole, distCoeffs: rest, xi, module: "omnidir" };
    return { ...pinhole, distCoeffs: [xi, ...rest], module: this.distortion_model === "fisheye" ? "fisheye" : "" };
  }

  /**
   * Straightens the picture on the GPU; loaded when it is first asked for.
   * @template {import("./warp.js").AnyCanvas} [Canvas=HTMLCanvasElement]
   * @param {import("./rectifier.js").Options<Canvas>} [options]
   */
  async rectifier(options) {
    const { Rectifier } = await import("./rectifier.js");
    return new Rectifier(this, options);
  }

  /**
   * Distorts a scene as the camera would; loaded when it is first asked for.
   * @template {import("./warp.js").AnyCanvas} [Canvas=HTMLCanvasElement]
   * @param {import("./distorter.js").Options<Canvas>} [options]
   */
  async distorter(options) {
    const { Distorter } = await import("./distorter.js");
    return new Distorter(this, options);
  }
}

/**
 * What projects a scene onto the picture of a pinhole: column-major, as in WebXR, three.js and `uniformMatrix4fv`. The
 * scene's camera looks along −z with y up: its frame is diag(1, −1, −1) of ours.
 * @param {{img_size: readonly [number, number], camera_matrix: number[][]}} pinhole
 * @param {Frustum} [frustum]
 * @returns {number[]} 16 numbers
 */
export function projectionMatrix(pinhole, { near = 0.1, far = 1000, viewport = pinhole.img_size, fit = "cover", depth = [-1, 1] } = {}) {
  const { img_size: size, camera_matrix: [[fx, , cx], [, fy, cy]] } = pinhole;
  const [sx, sy] = scales(size, viewport, fit);
  // Along each axis, in pixels counted from the viewport's edge, where those of the picture are counted from its first centre.
  const x = (viewport[0] + sx * (2 * cx + 1 - size[0])) / viewport[0] - 1;
  const y = (viewport[1] + sy * (2 * cy + 1 - size[1])) / viewport[1] - 1;
  const ratio = near / far;
  const a = (depth[1] - depth[0] * ratio) / (ratio - 1);
  const b = near * (a + depth[0]);
  return [(2 * sx * fx) / viewport[0], 0, 0, 0, 0, (2 * sy * fy) / viewport[1], 0, 0, -x, y, a, -1, 0, 0, b, 0];
}

/** How much larger the picture is shown. @param {readonly [number, number]} size @param {readonly [number, number]} viewport @param {Fit} fit */
function scales(size, viewport, fit) {
  const [x, y] = [viewport[0] / size[0], viewport[1] / size[1]];
  if (fit === "fill") return [x, y];
  if (fit === "none") return [1, 1];
  const scale = fit === "cover" ? Math.max(x, y) : Math.min(x, y, fit === "contain" ? Infinity : 1);
  return [scale, scale];
}
