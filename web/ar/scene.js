// Scene of triangles, drawn as a pinhole sees them. WebGL2, without dependencies.
import { createProgram, whenRestored } from "../sdk/warp.js";
import { projectionMatrix } from "../sdk/pinhole.js";
import { rotationMatrix } from "../lib/pose.js";

/**
 * @import { Pose } from "../lib/pose.js"
 * @import { Pinhole } from "../sdk/pinhole.js"
 */

const VERTEX = `#version 300 es
uniform mat4 projection;
uniform mat4 view;
in vec3 place;
in vec3 colour;
out vec3 shade;
void main() {
  gl_Position = projection * view * vec4(place, 1.0);
  shade = colour;
}`;

const FRAGMENT = `#version 300 es
precision mediump float;
in vec3 shade;
out vec4 colour;
void main() {
  colour = vec4(shade, 1.0);
}`;

const NUMBERS = 6; // a vertex: place, colour

export class Scene {
  #on;
  #forget;
  #count;

  /** @param {Float32Array} triangles see model.js; throws RectifierError where there is no WebGL2 */
  constructor(triangles) {
    const canvas = (this.canvas = document.createElement("canvas"));
    this.#count = triangles.length / NUMBERS;
    this.#on = createRenderer(canvas, triangles);
    this.#forget = whenRestored(canvas, () => {
      this.#on = createRenderer(canvas, triangles);
    });
  }

  /**
   * @param {Pinhole} pinhole whose picture it becomes
   * @param {Pose | null} pose null: nothing is there
   */
  draw(pinhole, pose) {
    const { gl, program } = this.#on;
    const [width, height] = pinhole.img_size;
    if (this.canvas.width !== width || this.canvas.height !== height)
      [this.canvas.width, this.canvas.height] = [width, height];
    gl.viewport(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    if (!pose) return;
    const projection = projectionMatrix(pinhole, { near: 0.1, far: 500 });
    gl.uniformMatrix4fv(gl.getUniformLocation(program, "projection"), false, projection);
    gl.uniformMatrix4fv(gl.getUniformLocation(program, "view"), false, viewMatrix(pose));
    gl.drawArrays(gl.TRIANGLES, 0, this.#count);
  }

  /** Frees what it holds on the GPU. */
  dispose() {
    const { gl, program, buffer } = this.#on;
    this.#forget();
    gl.deleteBuffer(buffer);
    gl.deleteProgram(program);
    gl.getExtension("WEBGL_lose_context")?.loseContext();
  }
}

/** @param {HTMLCanvasElement} canvas @param {Float32Array} triangles */
function createRenderer(canvas, triangles) {
  const { gl, program } = createProgram(canvas, { alpha: true, antialias: true }, VERTEX, FRAGMENT);
  const buffer = gl.createBuffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  gl.bufferData(gl.ARRAY_BUFFER, triangles, gl.STATIC_DRAW);
  for (const [name, offset] of /** @type {const} */ ([
    ["place", 0],
    ["colour", 3],
  ])) {
    const at = gl.getAttribLocation(program, name);
    gl.enableVertexAttribArray(at);
    gl.vertexAttribPointer(at, 3, gl.FLOAT, false, 4 * NUMBERS, 4 * offset);
  }
  gl.enable(gl.DEPTH_TEST);
  return { gl, program, buffer };
}

/**
 * OpenGL's cameras look along −z with y up.
 * @param {Pose} pose
 * @returns {number[]} column-major
 */
function viewMatrix({ rvec, tvec: [x, y, z] }) {
  const [a, b, c, d, e, f, g, h, i] = rotationMatrix(rvec);
  return [a, -d, -g, 0, b, -e, -h, 0, c, -f, -i, 0, x, -y, -z, 1];
}
