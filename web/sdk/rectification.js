// Rectification: matrices of pinholes that see what a camera sees, and maps between the two pictures.
import { focalLengths } from "./pinhole.js";
import { lensOf } from "./projection.js";

/**
 * @typedef {import("./projection.js").Intrinsics & {img_size: [number, number]}} Calibration
 * @typedef {[number, number, number, number]} Rectangle left, top, right, bottom, on the plane z = 1
 */

const NO_ROTATION = [1, 0, 0, 0, 1, 0, 0, 0, 1];
/** tan of the largest angle shown, 78.7°: beyond it a plane picture is all edge. */
const MAX_TANGENT_SHOWN = 5;
const BORDER_SAMPLES = 33; // places along each side of the picture whose rays decide what there is to show

/**
 * The camera matrix of the straightened picture, of the same size.
 * @param {Calibration} calibration @param {number} [balance] 0: only what is picture everywhere, to 1: all of it
 * @param {number} [zoom] how much larger than that
 * @returns {number[][]}
 */
export function rectifiedMatrix(calibration, balance = 0, zoom = 1) {
  const [width, height] = calibration.img_size;
  const { inner, outer } = rayBounds(calibration);
  // Between the two rectangles, each with the shape of the picture.
  const [narrow, wide] = [focal(inner, width, height, Math.max), focal(outer, width, height, Math.min)];
  const f = zoom * (narrow + balance * (wide - narrow));
  const [x, y] = [0, 1].map((axis) => {
    const [a, b] = [inner[axis] + inner[axis + 2], outer[axis] + outer[axis + 2]];
    return (a + balance * (b - a)) / 2;
  });
  return [
    [f, 0, (width - 1) / 2 - f * x],
    [0, f, (height - 1) / 2 - f * y],
    [0, 0, 1],
  ];
}

/**
 * Pixels a unit with which a rectangle fills the picture, or fits into it.
 * @param {Rectangle} rectangle
 * @param {number} width
 * @param {number} height
 * @param {typeof Math.max} choose
 */
function focal([left, top, right, bottom], width, height, choose) {
  return choose(width / (right - left), height / (bottom - top));
}

/**
 * The largest rectangle of rays that are all in the picture, and the smallest that holds all.
 * @param {Calibration} calibration
 */
function rayBounds(calibration) {
  const {
    img_size: [width, height],
    camera_matrix: [[fx, , cx], [, fy, cy]],
  } = calibration;
  const lens = lensOf(calibration);
  /**
   * Intersection of a pixel's ray with the plane z = 1, pulled in where that is far out or nowhere.
   * @param {number} u
   * @param {number} v
   * @returns {[number, number]}
   */
  const meet = (u, v) => {
    const ray = lens.unproject([u, v]);
    const [x, y] = ray ?? [(u - cx) / fx, (v - cy) / fy];
    const r = Math.hypot(x, y);
    const tangent = ray ? (ray[2] > 0 ? r / ray[2] : Infinity) : Math.tan(Math.min(lens.limit, 1.5));
    const length = Math.min(tangent, MAX_TANGENT_SHOWN);
    return r > 0 ? [(x * length) / r, (y * length) / r] : [0, 0];
  };
  /** @type {Rectangle} */
  const inner = [-Infinity, -Infinity, Infinity, Infinity];
  /** @type {Rectangle} */
  const outer = [Infinity, Infinity, -Infinity, -Infinity];
  for (let step = 0; step < BORDER_SAMPLES; step++) {
    const [u, v] = [width, height].map((side) => (step * (side - 1)) / (BORDER_SAMPLES - 1));
    const [left, right, top, bottom] = [meet(0, v), meet(width - 1, v), meet(u, 0), meet(u, height - 1)];
    inner[0] = Math.max(inner[0], left[0]);
    inner[1] = Math.max(inner[1], top[1]);
    inner[2] = Math.min(inner[2], right[0]);
    inner[3] = Math.min(inner[3], bottom[1]);
    for (const [x, y] of [left, right, top, bottom]) {
      outer[0] = Math.min(outer[0], x);
      outer[1] = Math.min(outer[1], y);
      outer[2] = Math.max(outer[2], x);
      outer[3] = Math.max(outer[3], y);
    }
  }
  return { inner, outer };
}

/**
 * A pinhole that sees all that the camera sees, and at its middle as sharply.
 * @param {Calibration} calibration
 * @param {number} [largest] how many times wider or higher than the camera's picture it may be
 * @returns {import("./pinhole.js").Pinhole}
 */
export function widePinhole(calibration, largest = 2) {
  const {
    img_size: [width, height],
  } = calibration;
  const {
    outer: [left, top, right, bottom],
  } = rayBounds(calibration);
  const f = Math.min(
    Math.max(...focalLengths(calibration)),
    (largest * width) / (right - left),
    (largest * height) / (bottom - top),
  );
  // A pixel more on each side: what lies between the outermost and the edge is interpolated.
  return {
    img_size: [Math.ceil(f * (right - left)) + 3, Math.ceil(f * (bottom - top)) + 3],
    camera_matrix: [
      [f, 0, 1 - f * left],
      [0, f, 1 - f * top],
      [0, 0, 1],
    ],
  };
}

/**
 * For every pixel of the straightened picture, where it is in the camera's.
 * @param {Calibration} calibration @param {number[][]} matrix of the straightened picture
 * @param {[number, number]} [size] of the straightened picture, that of the camera's by default
 * @param {readonly number[]} [rotation] row-major 3x3, frame of the straightened picture → camera; none by default
 * @returns {Float32Array} x and y, px, row by row; far outside where the lens sees nothing
 */
export function rectifyingMap(
  calibration,
  [[fx, , cx], [, fy, cy]],
  size = calibration.img_size,
  rotation = NO_ROTATION,
) {
  const lens = lensOf(calibration);
  const [a, b, c, d, e, f, g, h, i] = rotation;
  return mapOf(size, (u, v) => {
    const [x, y] = [(u - cx) / fx, (v - cy) / fy];
    return lens.project([a * x + b * y + c, d * x + e * y + f, g * x + h * y + i]);
  });
}

/**
 * For every pixel of the camera's picture, where it is in a pinhole's.
 * @param {Calibration} calibration @param {number[][]} matrix of the pinhole
 * @returns {Float32Array} x and y, px, row by row; far outside where the pinhole sees nothing
 */
export function distortingMap(calibration, [[fx, , cx], [, fy, cy]]) {
  const lens = lensOf(calibration);
  return mapOf(calibration.img_size, (u, v) => {
    const ray = lens.unproject([u, v]);
    return ray && ray[2] > 0 ? [(fx * ray[0]) / ray[2] + cx, (fy * ray[1]) / ray[2] + cy] : null;
  });
}

export const NOWHERE = -1e6; // px, outside of every picture

/** @param {[number, number]} size @param {(u: number, v: number) => [number, number] | null} place */
function mapOf([width, height], place) {
  const map = new Float32Array(2 * width * height);
  for (let v = 0, at = 0; v < height; v++) {
    for (let u = 0; u < width; u++, at += 2) [map[at], map[at + 1]] = place(u, v) ?? [NOWHERE, NOWHERE];
  }
  return map;
}
