// Straightens a camera's picture on the GPU. WebGL2; one file beside projection.js, without dependencies.
//
//     import { Rectifier } from "https://<host>/sdk/rectifier.js";
//     const rectifier = new Rectifier(calibration, { balance: 0 });
//     document.body.append(rectifier.canvas);
//     rectifier.draw(video); // once a frame
//     rectifier.camera_matrix; // of the picture it draws, which has no distortion
//     rectifier.dispose();
import { lensOf } from "./projection.js";

/**
 * @typedef {import("./projection.js").Intrinsics & {img_size: [number, number]}} Calibration
 * @typedef {[number, number, number, number]} Rectangle left, top, right, bottom, on the plane z = 1
 *
 * @typedef {object} Options
 * @property {number} [balance] 0: only what is picture everywhere; 1: all of the picture, with black edges
 * @property {HTMLCanvasElement | OffscreenCanvas} [canvas] to draw into; one is made unless told
 */

/** tan of the largest angle shown, 78.7°: beyond it a plane picture is all edge. */
const WIDEST = 5;
const BORDER = 33; // places along each side of the picture whose rays decide what there is to show

const VERTEX = `#version 300 es
void main() {
  // One triangle over everything, from nothing but the index.
  gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0);
}`;

const FRAGMENT = `#version 300 es
precision highp float;
uniform sampler2D picture;
uniform highp sampler2D map;
out vec4 colour;
void main() {
  ivec2 size = textureSize(map, 0);
  // Rows of pictures run down, those of the canvas up.
  vec2 at = texelFetch(map, ivec2(gl_FragCoord.x, float(size.y) - gl_FragCoord.y), 0).xy;
  bool inside = at.x > -0.5 && at.y > -0.5 && at.x < float(size.x) - 0.5 && at.y < float(size.y) - 0.5;
  colour = inside ? vec4(texture(picture, (at + 0.5) / vec2(size)).rgb, 1.0) : vec4(0.0, 0.0, 0.0, 1.0);
}`;

/** This browser cannot do it. */
export class RectifierError extends Error {}

/**
 * The camera matrix of the straightened picture, of the same size.
 * @param {Calibration} calibration @param {number} [balance] 0…1
 * @returns {number[][]}
 */
export function rectifiedMatrix(calibration, balance = 0) {
  const [width, height] = calibration.img_size;
  const { inner, outer } = seen(calibration);
  // Between the two rectangles, each with the shape of the picture.
  const [narrow, wide] = [focal(inner, width, height, Math.max), focal(outer, width, height, Math.min)];
  const f = narrow + balance * (wide - narrow);
  const [x, y] = [0, 1].map((axis) => {
    const [a, b] = [inner[axis] + inner[axis + 2], outer[axis] + outer[axis + 2]];
    return (a + balance * (b - a)) / 2;
  });
  return [[f, 0, (width - 1) / 2 - f * x], [0, f, (height - 1) / 2 - f * y], [0, 0, 1]];
}

/** Pixels a unit with which a rectangle fills the picture, or fits into it. @param {Rectangle} rectangle @param {number} width @param {number} height @param {typeof Math.max} choose */
function focal([left, top, right, bottom], width, height, choose) {
  return choose(width / (right - left), height / (bottom - top));
}

/** The largest rectangle of rays that are all in the picture, and the smallest that holds all. @param {Calibration} calibration */
function seen(calibration) {
  const { img_size: [width, height], camera_matrix: [[fx, , cx], [, fy, cy]] } = calibration;
  const lens = lensOf(calibration);
  /** Where a pixel's ray meets the plane z = 1, pulled in where that is far out or nowhere. @param {number} u @param {number} v @returns {[number, number]} */
  const meet = (u, v) => {
    const ray = lens.unproject([u, v]);
    const [x, y] = ray ?? [(u - cx) / fx, (v - cy) / fy];
    const r = Math.hypot(x, y);
    const tangent = ray ? (ray[2] > 0 ? r / ray[2] : Infinity) : Math.tan(Math.min(lens.limit, 1.5));
    const length = Math.min(tangent, WIDEST);
    return r > 0 ? [(x * length) / r, (y * length) / r] : [0, 0];
  };
  /** @type {Rectangle} */
  const inner = [-Infinity, -Infinity, Infinity, Infinity];
  /** @type {Rectangle} */
  const outer = [Infinity, Infinity, -Infinity, -Infinity];
  for (let step = 0; step < BORDER; step++) {
    const [u, v] = [width, height].map((side) => (step * (side - 1)) / (BORDER - 1));
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
 * For every pixel of the straightened picture, where it is in the camera's.
 * @param {Calibration} calibration @param {number[][]} matrix of the straightened picture
 * @returns {Float32Array} x and y, px, row by row; far outside where the lens sees nothing
 */
export function rectifyingMap(calibration, [[fx, , cx], [, fy, cy]]) {
  const [width, height] = calibration.img_size;
  const lens = lensOf(calibration);
  const map = new Float32Array(2 * width * height);
  for (let y = 0, at = 0; y < height; y++) {
    for (let x = 0; x < width; x++, at += 2) {
      const pixel = lens.project([(x - cx) / fx, (y - cy) / fy, 1]);
      map[at] = pixel ? pixel[0] : -1e6;
      map[at + 1] = pixel ? pixel[1] : -1e6;
    }
  }
  return map;
}

export class Rectifier {
  #gl;
  #textures;
  #program;
  #calibration;
  /** @type {number[][]} */
  #matrix = [];

  /** @param {Calibration} calibration @param {Options} [options] */
  constructor(calibration, { balance = 0, canvas = document.createElement("canvas") } = {}) {
    this.#calibration = calibration;
    this.canvas = canvas;
    [canvas.width, canvas.height] = calibration.img_size;
    const gl = /** @type {WebGL2RenderingContext | null} */ (canvas.getContext("webgl2", { alpha: false, antialias: false }));
    if (!gl) throw new RectifierError("this browser has no WebGL2");
    this.#gl = gl;
    this.#program = program(gl);
    this.#textures = ["picture", "map"].map((name, unit) => {
      gl.uniform1i(gl.getUniformLocation(this.#program, name), unit);
      return texture(gl, unit, name === "map" ? gl.NEAREST : gl.LINEAR);
    });
    this.balance(balance);
  }

  /** Camera matrix of the picture drawn: a pinhole's, without distortion. */
  get camera_matrix() {
    return this.#matrix;
  }

  /** How much of the picture's edge to keep, 0…1. @param {number} value */
  balance(value) {
    const gl = this.#gl;
    const [width, height] = this.#calibration.img_size;
    this.#matrix = rectifiedMatrix(this.#calibration, value);
    const map = rectifyingMap(this.#calibration, this.#matrix);
    gl.activeTexture(gl.TEXTURE1);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RG32F, width, height, 0, gl.RG, gl.FLOAT, map);
  }

  /** @param {TexImageSource} picture of the calibration's size */
  draw(picture) {
    const gl = this.#gl;
    gl.activeTexture(gl.TEXTURE0);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, picture);
    gl.viewport(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /** Frees what it holds on the GPU: browsers give a page few contexts. */
  dispose() {
    const gl = this.#gl;
    for (const each of this.#textures) gl.deleteTexture(each);
    gl.deleteProgram(this.#program);
    gl.getExtension("WEBGL_lose_context")?.loseContext();
  }
}

/** @param {WebGL2RenderingContext} gl */
function program(gl) {
  const made = gl.createProgram();
  for (const [kind, source] of /** @type {const} */ ([[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]])) {
    const shader = gl.createShader(kind);
    if (!shader) throw new RectifierError("the GPU was lost");
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
    gl.deleteShader(shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new RectifierError(gl.getProgramInfoLog(made) ?? "the GPU was lost");
  gl.useProgram(made);
  return made;
}

/** @param {WebGL2RenderingContext} gl @param {number} unit @param {number} filter */
function texture(gl, unit, filter) {
  const made = gl.createTexture();
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(gl.TEXTURE_2D, made);
  for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, filter);
  for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
  return made;
}
