// Warping of a picture by a map of pixels, on the GPU: rectifier and distorter share its shaders. WebGL2.
/// <reference path="./dom.d.ts" preserve="true" />

/**
 * @typedef {HTMLCanvasElement | OffscreenCanvas} AnyCanvas
 *
 * @typedef {object} PixelMap source coordinates of each pixel that is drawn
 * @property {Float32Array} map x and y in px of the source, row by row
 * @property {[number, number]} size of what is drawn, px
 * @property {[number, number]} extent of the source, in the map's px
 */

const VERTEX = `#version 300 es
void main() {
  // One triangle over everything, from nothing but the index.
  gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0);
}`;

const FRAGMENT = `#version 300 es
precision highp float;
uniform sampler2D picture;
uniform highp sampler2D map;
uniform vec2 extent;
uniform vec4 edge;
out vec4 colour;
void main() {
  // Rows of pictures run down, those of the canvas up.
  vec2 at = texelFetch(map, ivec2(gl_FragCoord.x, float(textureSize(map, 0).y) - gl_FragCoord.y), 0).xy;
  bool inside = at.x > -0.5 && at.y > -0.5 && at.x < extent.x - 0.5 && at.y < extent.y - 0.5;
  colour = inside ? texture(picture, (at + 0.5) / extent) : edge;
}`;

const LOST = "the GPU was lost";

/** This browser has no WebGL2, or has lost the GPU. */
export class RectifierError extends Error {
  /** @param {string} message @param {boolean} [lost] it could, and another time may help */
  constructor(message, lost = false) {
    super(message);
    this.lost = lost;
  }
}

export class Warp {
  #alpha;
  #on;
  #forget;
  /** @type {() => PixelMap} */
  #createMap = () => ({ map: new Float32Array(2), size: [1, 1], extent: [1, 1] });

  /**
   * @param {AnyCanvas} canvas
   * @param {{alpha: boolean}} options alpha: transparent where there is nothing, else black
   */
  constructor(canvas, { alpha }) {
    this.canvas = canvas;
    this.#alpha = alpha;
    this.#on = createRenderer(canvas, alpha);
    this.#forget = whenRestored(canvas, () => {
      this.#on = createRenderer(canvas, alpha);
      this.setMap(this.#createMap);
    });
  }

  /** Sets the map. @param {() => PixelMap} create called again when the GPU lost it */
  setMap(create) {
    this.#createMap = create;
    const {
      map,
      size: [width, height],
      extent,
    } = create();
    const { gl, program } = this.#on;
    if (this.canvas.width !== width || this.canvas.height !== height)
      [this.canvas.width, this.canvas.height] = [width, height];
    gl.uniform2f(gl.getUniformLocation(program, "extent"), ...extent);
    gl.activeTexture(gl.TEXTURE1);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RG32F, width, height, 0, gl.RG, gl.FLOAT, map);
  }

  /** @param {TexImageSource} picture as large as the map's extent, or of its shape */
  draw(picture) {
    const { gl } = this.#on;
    gl.activeTexture(gl.TEXTURE0);
    // The colour of what is transparent would bleed into its neighbours otherwise.
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, this.#alpha);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, picture);
    gl.viewport(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /** Frees what it holds on the GPU: browsers give a page few contexts. */
  dispose() {
    const { gl, program, textures } = this.#on;
    this.#forget();
    for (const each of textures) gl.deleteTexture(each);
    gl.deleteProgram(program);
    gl.getExtension("WEBGL_lose_context")?.loseContext();
  }
}

/** A canvas of the page, the default. */
export const createCanvas = () => /** @type {any} */ (document.createElement("canvas"));

/**
 * Calls `again` when a lost GPU context is back, to make its content again.
 * @param {EventTarget} canvas @param {() => void} again
 * @returns {() => void} ends it
 */
export function whenRestored(canvas, again) {
  const over = new AbortController();
  const { signal } = over;
  canvas.addEventListener("webglcontextlost", (event) => event.preventDefault(), { signal }); // else it stays lost
  canvas.addEventListener("webglcontextrestored", again, { signal });
  return () => over.abort();
}

/** @param {AnyCanvas} canvas @param {boolean} alpha */
function createRenderer(canvas, alpha) {
  const { gl, program } = createProgram(canvas, { alpha, antialias: false }, VERTEX, FRAGMENT);
  const textures = ["picture", "map"].map((name, unit) => {
    gl.uniform1i(gl.getUniformLocation(program, name), unit);
    return texture(gl, unit, name === "map" ? gl.NEAREST : gl.LINEAR);
  });
  gl.uniform4f(gl.getUniformLocation(program, "edge"), 0, 0, 0, alpha ? 0 : 1);
  return { gl, program, textures };
}

/**
 * A canvas' context, with one program in use.
 * @param {AnyCanvas} canvas @param {WebGLContextAttributes} attributes
 * @param {string} vertex @param {string} fragment sources
 * @returns {{gl: WebGL2RenderingContext, program: WebGLProgram}} throws RectifierError where there is no WebGL2
 */
export function createProgram(canvas, attributes, vertex, fragment) {
  const gl = /** @type {WebGL2RenderingContext | null} */ (canvas.getContext("webgl2", attributes));
  if (!gl) throw new RectifierError("this browser has no WebGL2");
  const program = gl.createProgram();
  for (const [kind, source] of /** @type {const} */ ([
    [gl.VERTEX_SHADER, vertex],
    [gl.FRAGMENT_SHADER, fragment],
  ])) {
    const shader = gl.createShader(kind);
    if (!shader) throw new RectifierError(LOST, true);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
    gl.deleteShader(shader);
  }
  gl.linkProgram(program);
  if (gl.isContextLost()) throw new RectifierError(LOST, true);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new RectifierError(gl.getProgramInfoLog(program) ?? "");
  gl.useProgram(program);
  return { gl, program };
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
