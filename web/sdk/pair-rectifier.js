// Rectifier of the pictures of two cameras, on the GPU: a point lies in the same row of both. WebGL2, without
// dependencies.
import { rotate, transpose } from "./motion.js";
import { NOWHERE, rectifyingMap } from "./rectification.js";
import { rectifiedMotions, rectify } from "./stereo.js";
import { createViews } from "./views.js";
import { Warp, createCanvas } from "./warp.js";

/**
 * @typedef {import("./warp.js").AnyCanvas} AnyCanvas
 * @typedef {TexImageSource} Source a video, a canvas, an image, a VideoFrame
 * @typedef {import("./stereo.js").TwoCameras} TwoCameras
 *
 * @typedef {"beside" | "above"} Packing how a camera delivers both pictures in one: the left one next to the right
 *   one, or above it
 */
/**
 * @template {AnyCanvas} [Canvas=HTMLCanvasElement]
 * @typedef {object} CanvasOptions
 * @property {readonly [Canvas, Canvas]} [canvases] to draw into; two are made by default
 * @property {Packing} [packing] of a picture that holds both; each has its own by default
 */
/**
 * @template {AnyCanvas} [Canvas=HTMLCanvasElement]
 * @typedef {CanvasOptions<Canvas> & import("./stereo.js").Layout} PairOptions
 */

const SAME_SHAPE = 0.01; // relative difference of two ratios of width and height
const NAMES = ["left", "right"];

/** @template {AnyCanvas} [Canvas=HTMLCanvasElement] */
export class PairRectifier {
  #sources;
  #cameras;
  #warps;
  #motions;
  #wholes;

  /**
   * @param {Source} left @param {Source} right
   * @param {TwoCameras} cameras
   * @param {PairOptions<Canvas>} [options]
   */
  constructor(
    left,
    right,
    { left: one, right: other, pose },
    { scale, zoom, packing, canvases = [createCanvas(), createCanvas()] } = {},
  ) {
    this.#sources = [left, right];
    this.#cameras = [one, other];
    this.#wholes = this.#cameras.map((camera, index) => placeOf(camera.img_size, index, packing));
    /** All that `cv.stereoRectify` returns, and focal length, baseline and direction. */
    this.rectification = rectify(one, other, pose, { scale, zoom });
    this.#check([left, right]);
    this.#motions = rectifiedMotions(this.rectification, pose);
    const { R1, R2 } = this.rectification;
    const { camera_matrix: matrix, img_size: size } = this;
    /** Canvas with the rectified left picture. */
    this.left = canvases[0];
    /** Canvas with the rectified right picture. */
    this.right = canvases[1];
    this.#warps = canvases.map((canvas, index) => {
      const warp = new Warp(canvas, { alpha: false });
      const { extent, offset } = this.#wholes[index];
      const back = transpose([R1, R2][index].flat());
      const camera = this.#cameras[index];
      warp.setMap(() => ({
        map: place(rectifyingMap(camera, matrix, size, back), camera.img_size, offset),
        size,
        extent,
      }));
      return warp;
    });
    this.draw();
  }

  /** Size of both rectified pictures, px. */
  get img_size() {
    return this.rectification.img_size;
  }

  /** Camera matrix of both rectified pictures: a pinhole's, without distortion. */
  get camera_matrix() {
    return this.rectification.P1.map((row) => row.slice(0, 3));
  }

  /** px: depth = focal * baseline / disparity. */
  get focal() {
    return this.rectification.focal;
  }

  /** In the unit of the pose. */
  get baseline() {
    return this.rectification.baseline;
  }

  /**
   * Draws both rectified pictures, by default of the sources given to the constructor.
   * @param {Source} [left] @param {Source} [right]
   * @returns {boolean} false: a video shows nothing yet, and both canvases stay as they were
   */
  draw(left = this.#sources[0], right = this.#sources[1]) {
    const pictures = [left, right];
    if (pictures.some((picture) => sizeOf(picture)[0] === 0)) return false;
    this.#check(pictures);
    this.#warps.forEach((warp, index) => warp.draw(pictures[index]));
    return true;
  }

  /**
   * Depth of a disparity: x (of vertical pairs y) in the left rectified picture minus that in the right one.
   * @param {number} disparity px
   * @returns {number} along the rectified cameras' axis, in the unit of the pose
   */
  depth(disparity) {
    return (this.focal * this.baseline) / disparity;
  }

  /**
   * Point of a pixel of the left rectified picture.
   * @param {readonly [number, number]} pixel @param {number} disparity px
   * @returns {[number, number, number]} frame of the left camera itself (x right, y down, z forward), in the unit of
   *   the pose
   */
  point([u, v], disparity) {
    const {
      R1,
      P1: [[f, , cx], [, , cy]],
    } = this.rectification;
    const z = this.depth(disparity);
    const rectified = [((u - cx) * z) / f, ((v - cy) * z) / f, z];
    return /** @type {[number, number, number]} */ (rotate(transpose(R1.flat()), rectified));
  }

  /**
   * Views of scenes over both rectified pictures, as WebXR has them, that of the left eye first. The world is the frame
   * of the left camera.
   * @param {import("./views.js").ViewOptions} [options]
   */
  views(options) {
    const pinhole = { img_size: this.img_size, camera_matrix: this.camera_matrix };
    const eyes = this.baseline < 0 ? [1, 0] : [0, 1];
    return createViews(
      eyes.map((each, index) => ({ eye: index ? "right" : "left", pinhole, motion: this.#motions[each] })),
      options,
    );
  }

  /** Frees what it holds on the GPU: browsers give a page few contexts. */
  dispose() {
    for (const warp of this.#warps) warp.dispose();
  }

  /** @param {readonly Source[]} pictures */
  #check(pictures) {
    pictures.forEach((picture, index) => {
      const [width, height] = sizeOf(picture);
      const [w, h] = this.#wholes[index].extent;
      if (width === 0 || Math.abs((width * h) / (height * w) - 1) < SAME_SHAPE) return;
      throw new TypeError(
        `the ${NAMES[index]} picture has ${width} x ${height} px, its calibration is for ${w} x ${h} px`,
      );
    });
  }
}

/**
 * Place of a camera's picture in the one that it comes in.
 * @param {readonly [number, number]} size @param {number} index 0: left @param {Packing} [packing]
 * @returns {{extent: [number, number], offset: [number, number]}} size of the whole, and where in it the camera's
 *   begins, px
 */
function placeOf([width, height], index, packing) {
  if (packing === "beside") return { extent: [2 * width, height], offset: [index * width, 0] };
  if (packing === "above") return { extent: [width, 2 * height], offset: [0, index * height] };
  return { extent: [width, height], offset: [0, 0] };
}

/**
 * A map into a part of a picture; of what is outside of that part nothing is shown.
 * @param {Float32Array} map
 * @param {readonly [number, number]} size of the part
 * @param {readonly [number, number]} offset
 */
function place(map, [width, height], [left, top]) {
  for (let at = 0; at < map.length; at += 2) {
    const inside = map[at] > -0.5 && map[at + 1] > -0.5 && map[at] < width - 0.5 && map[at + 1] < height - 0.5;
    map[at] = inside ? map[at] + left : NOWHERE;
    map[at + 1] = inside ? map[at + 1] + top : NOWHERE;
  }
  return map;
}

/** @param {Source} picture @returns {[number, number]} px; 0 of a video or an image that shows nothing yet */
function sizeOf(picture) {
  if ("videoWidth" in picture) return [picture.videoWidth, picture.videoHeight];
  if ("naturalWidth" in picture) return [picture.naturalWidth, picture.naturalHeight];
  if ("displayWidth" in picture) return [picture.displayWidth, picture.displayHeight];
  return [picture.width, picture.height];
}
