// Cameras that the service answers with, calibrated or estimated, and functions of them.
import { projectionMatrix } from "./pinhole.js";
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
 * @property {number | null} [systematic] variance that the intrinsics see / that of white noise, at least 1
 * @property {"scale" | "crop" | "scale+crop" | "neither" | null} [relation] of this size to the one asked for, where
 *   verified
 * @property {Adapted | null} [adapted] parameters for the size or zoom asked for, where verified
 * @property {number} calibrations how many agree on this
 * @property {number} contributors
 * @property {boolean} reliable
 * @property {boolean} exact_size false: the closest known size, not the one asked for
 * @property {{rms: number, max: number, inside?: number | null, covered?: number | null}} uncertainty predicted
 *   projection error, px: over the image, and `inside` the part that the boards have shown, a share `covered` of the
 *   image
 * @property {number} calibration_time unix seconds
 *
 * @typedef {object} CameraData what projects
 * @property {[number, number]} img_size
 * @property {number[][]} camera_matrix row-major 3x3, px; the centre of the top-left pixel is (0, 0)
 * @property {number[]} distortion_coefficients in the order that the model's name says
 * @property {string} distortion_model
 *
 * @typedef {object} OnlyEstimated
 * @property {number} hfov_deg horizontal field of view, degrees
 * @property {{hfov_deg: [number, number]}} interval_90 contains the true value with a probability of 90 %
 * @property {"calibrations" | "views" | "device" | "other_size" | "published" | "family" | "population"} basis best
 *   evidence
 * @property {string} [group] name of the group of calibrations that fits the views sent
 * @property {{title: string, url: string}[]} sources publications that it rests on
 *
 * @typedef {CameraData & OnlyEstimated} EstimateData of a camera of which nothing reliable is known
 *
 * @typedef {object} OpenCV
 * @property {[number, number]} imageSize
 * @property {number[]} cameraMatrix 3x3, row by row
 * @property {number[]} distCoeffs
 * @property {"" | "fisheye" | "omnidir"} module of `cv` whose functions take them
 * @property {number} [xi] what `omnidir` takes besides
 */

/** The service's answer, field by field, whatever fields it has. */
class Fields {
  /** @param {CameraData} data */
  constructor(data) {
    Object.assign(this, data);
  }
}

const Data = /** @type {new (data: CameraData) => CameraData} */ (/** @type {unknown} */ (Fields));

/** A camera: its data, unchanged, with functions. */
export class Camera extends Data {
  /** @type {ReturnType<typeof lensOf> | undefined} */
  #lens;

  get #model() {
    return (this.#lens ??= lensOf(this));
  }

  /** @param {readonly number[]} point camera frame, x right, y down, z forward @returns {[number, number] | null} px */
  project(point) {
    return this.#model.project(point);
  }

  /** @param {readonly number[]} pixel @returns {[number, number, number] | null} unit ray */
  unproject(pixel) {
    return this.#model.unproject(pixel);
  }

  /**
   * For a scene over the picture, which must be rectified or nearly without distortion.
   * @param {import("./pinhole.js").Frustum} [frustum]
   */
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

const OfCalibration = /** @type {new (data: CalibrationData) => Camera & CalibrationData} */ (
  /** @type {unknown} */ (Camera)
);
const OfEstimate = /** @type {new (data: EstimateData) => Camera & EstimateData} */ (/** @type {unknown} */ (Camera));

/** A calibration, with functions. */
export class Calibration extends OfCalibration {}

/** A likely camera, to draw with until it is calibrated; never a calibration. */
export class Estimate extends OfEstimate {}
