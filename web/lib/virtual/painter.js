// Painter of the board as a camera with a known lens sees it. Pure: numbers in, pixels out.
import { outline } from "../board.js";
import { exactScale, raster } from "../board-drawing.js";
import { rotationMatrix } from "../pose.js";
import { projectionOf } from "./lens.js";

/**
 * @import { Board } from "../board.js"
 * @import { Pose } from "../pose.js"
 * @import { LensParameters } from "./lens.js"
 */

const MAX_TEXELS_PER_SQUARE = 64;
const BORDER_TEXELS = 32; // texels of white paper around the board
const BACKGROUND = 112;
const SAMPLES_PER_AXIS = 3; // a pixel, each way: corners come out 0.05 px right
const EVEN_RADIUS = 2; // texels: if all within this radius are equal, one sample gives the same as nine
// texels, both diagonals of a pixel together: less than 4.5, and what its samples look at is within that radius
const NEAR = 4;

export class Painter {
  /** Rays at the corners of the pixels, x and y at z = 1; NaN where the lens sees nothing. */
  #rays;
  #texture;
  /** Texels per board unit. */
  #scale;
  /** Texel of the board's origin: an AprilGrid's is at its lower left. */
  #origin;
  /** 1 where the texture is the same all around. @type {Uint8Array} */
  #even;
  #size;
  /** @type {Float32Array} board coordinates at two rows of pixel corners */
  #rows;

  /** @param {Board} board @param {LensParameters} lens @param {[number, number]} size px */
  constructor(board, lens, size) {
    const [width, height] = size;
    const { unproject } = projectionOf(lens);
    this.#size = size;
    this.#scale = exactScale(board, MAX_TEXELS_PER_SQUARE);
    this.#texture = raster(board, this.#scale, BORDER_TEXELS);
    this.#origin = outline(board)[0].map((edge) => BORDER_TEXELS - this.#scale * edge - 0.5);
    this.#even = evenness(this.#texture);
    this.#rows = new Float32Array(4 * (width + 1));
    this.#rays = new Float32Array(2 * (width + 1) * (height + 1));
    for (let y = 0, at = 0; y <= height; y++) {
      for (let x = 0; x <= width; x++, at += 2) {
        const ray = unproject([x - 0.5, y - 0.5]);
        this.#rays[at] = ray ? ray[0] / ray[2] : NaN;
        this.#rays[at + 1] = ray ? ray[1] / ray[2] : NaN;
      }
    }
  }

  /** @param {Pose | null} pose board → camera, squares; null: no board @param {Uint8ClampedArray} rgba filled */
  paint(pose, rgba) {
    const pixels = new Uint32Array(rgba.buffer, rgba.byteOffset, rgba.byteLength / 4);
    pixels.fill(grey(BACKGROUND));
    if (!pose) return;
    const [width, height] = this.#size;
    const plane = inverse(pose);
    let upper = this.#rows.subarray(0, 2 * (width + 1));
    let lower = this.#rows.subarray(2 * (width + 1));
    this.#meet(plane, 0, upper);
    for (let y = 0; y < height; y++) {
      this.#meet(plane, y + 1, lower);
      this.#paintRow(upper, lower, pixels.subarray(y * width, (y + 1) * width));
      [upper, lower] = [lower, upper];
    }
  }

  /**
   * Intersections of a row of rays with the board's plane.
   * @param {number[]} plane
   * @param {number} y
   * @param {Float32Array} out texels
   */
  #meet(plane, y, out) {
    const [a, b, c, d, e, f, g, h, i] = plane;
    const rays = this.#rays;
    const [left, top] = this.#origin;
    const scale = this.#scale;
    for (let at = 0, ray = y * out.length; at < out.length; at += 2, ray += 2) {
      const [u, v] = [rays[ray], rays[ray + 1]];
      const depth = g * u + h * v + i;
      // Behind the camera, or past the horizon of the plane: not on the board.
      out[at] = depth > 0 ? ((a * u + b * v + c) / depth) * scale + left : NaN;
      out[at + 1] = depth > 0 ? ((d * u + e * v + f) / depth) * scale + top : NaN;
    }
  }

  /** @param {Float32Array} upper @param {Float32Array} lower @param {Uint32Array} pixels */
  #paintRow(upper, lower, pixels) {
    const { width, height, data } = this.#texture;
    const even = this.#even;
    const right = width - 1;
    const bottom = height - 1;
    for (let x = 0, at = 0; x < pixels.length; x++, at += 2) {
      // Without arrays: until the loop is optimized, it would make some for each pixel.
      const x0 = upper[at];
      const y0 = upper[at + 1];
      const x1 = upper[at + 2];
      const y1 = upper[at + 3];
      const x2 = lower[at];
      const y2 = lower[at + 1];
      const x3 = lower[at + 2];
      const y3 = lower[at + 3];
      const away =
        (x0 < 0 && x1 < 0 && x2 < 0 && x3 < 0) ||
        (x0 > right && x1 > right && x2 > right && x3 > right) ||
        (y0 < 0 && y1 < 0 && y2 < 0 && y3 < 0) ||
        (y0 > bottom && y1 > bottom && y2 > bottom && y3 > bottom);
      // Comparisons with NaN are false, so a ray that meets nothing needs a test of its own.
      if (away || Number.isNaN(x0 + x1 + x2 + x3 + y0 + y1 + y2 + y3)) continue;
      const near = Math.abs(x0 - x3) + Math.abs(x1 - x2) < NEAR && Math.abs(y0 - y3) + Math.abs(y1 - y2) < NEAR;
      const middle = Math.round((y0 + y1 + y2 + y3) / 4) * width + Math.round((x0 + x1 + x2 + x3) / 4);
      if (near && even[middle] === 1) {
        pixels[x] = grey(Math.round(24 + 0.84 * data[middle]));
        continue;
      }
      let sum = 0;
      for (let j = 0; j < SAMPLES_PER_AXIS; j++) {
        const t = (j + 0.5) / SAMPLES_PER_AXIS;
        const xl = x0 + t * (x2 - x0);
        const yl = y0 + t * (y2 - y0);
        const xr = x1 + t * (x3 - x1);
        const yr = y1 + t * (y3 - y1);
        for (let i = 0; i < SAMPLES_PER_AXIS; i++) {
          const s = (i + 0.5) / SAMPLES_PER_AXIS;
          const u = xl + s * (xr - xl);
          const v = yl + s * (yr - yl);
          if (u < 0 || v < 0 || u >= right || v >= bottom) {
            sum += BACKGROUND;
            continue;
          }
          const column = u | 0;
          const row = v | 0;
          const fu = u - column;
          const texel = row * width + column;
          const top = data[texel] + fu * (data[texel + 1] - data[texel]);
          const under = data[texel + width] + fu * (data[texel + width + 1] - data[texel + width]);
          // Ink is not quite black and paper not quite white.
          sum += 24 + 0.84 * (top + (v - row) * (under - top));
        }
      }
      pixels[x] = grey(Math.round(sum / (SAMPLES_PER_AXIS * SAMPLES_PER_AXIS)));
    }
  }
}

/**
 * Mask of texels whose neighbours within `EVEN_RADIUS` are alike: rows first, then columns.
 * @param {{width: number, height: number, data: Uint8Array}} texture
 */
function evenness({ width, height, data }) {
  const rows = new Uint8Array(data.length);
  const both = new Uint8Array(data.length);
  for (let y = 0; y < height; y++) {
    for (let x = EVEN_RADIUS, at = y * width + x; x < width - EVEN_RADIUS; x++, at++) {
      let k = -EVEN_RADIUS;
      while (k <= EVEN_RADIUS && data[at + k] === data[at]) k++;
      if (k > EVEN_RADIUS) rows[at] = 1;
    }
  }
  for (let at = EVEN_RADIUS * width; at < (height - EVEN_RADIUS) * width; at++) {
    let k = -EVEN_RADIUS;
    while (k <= EVEN_RADIUS && rows[at + k * width] === 1 && data[at + k * width] === data[at]) k++;
    if (k > EVEN_RADIUS) both[at] = 1;
  }
  return both;
}

/** @param {number} value */
const grey = (value) => ((255 << 24) | (value << 16) | (value << 8) | value) >>> 0;

/**
 * Ray → board plane: the inverse of [r1 r2 t], scaled so that the third row is positive in front of the camera.
 * @param {Pose} pose @returns {number[]} row-major 3x3
 */
function inverse({ rvec, tvec: [tx, ty, tz] }) {
  const [a, b, , d, e, , g, h] = rotationMatrix(rvec);
  const cofactors = [
    e * tz - ty * h,
    tx * h - b * tz,
    b * ty - tx * e,
    ty * g - d * tz,
    a * tz - tx * g,
    tx * d - a * ty,
    d * h - e * g,
    b * g - a * h,
    a * e - b * d,
  ];
  // The point on the ray (u, v, 1) is at depth 1 / (third row · ray), times the determinant.
  const determinant = a * cofactors[0] + b * cofactors[3] + tx * cofactors[6];
  return cofactors.map((value) => value / determinant);
}
