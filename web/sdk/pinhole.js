// Pinholes: their projection matrix for a scene, and their picture in another size.

/**
 * @typedef {object} Pinhole a picture without distortion
 * @property {[number, number]} img_size
 * @property {number[][]} camera_matrix
 *
 * @typedef {{camera_matrix: number[][]} & Partial<import("./projection.js").Intrinsics>} Matrix a calibration's, or a
 *   pinhole's
 *
 * @typedef {"cover" | "contain" | "fill" | "none" | "scale-down"} Fit CSS `object-fit`, centred
 *
 * @typedef {object} Frustum
 * @property {number} [near] @property {number} [far] in the scene's unit; Infinity is a number too
 * @property {readonly [number, number]} [viewport] what is drawn into, px of any kind; the picture's size by default
 * @property {Fit} [fit] how the picture lies in it; "cover" by default
 * @property {readonly [number, number]} [depth] what `near` and `far` become; [-1, 1] as in WebGL by default, [0, 1]
 *   in WebGPU
 */

/**
 * Focal lengths at the optical axis, px per radian. The diagonal of an omnidirectional camera's matrix holds them
 * times 1 + xi (Mei & Rives' generalised focal lengths).
 * @param {Matrix} intrinsics
 * @returns {[number, number]} along x and y
 */
export function focalLengths({ camera_matrix: [[fx], [, fy]], distortion_model, distortion_coefficients = [] }) {
  const scale = distortion_model === "omnidirectional" ? 1 + distortion_coefficients[0] : 1;
  return [fx / scale, fy / scale];
}

/**
 * Camera matrix of the pinhole that magnifies as a lens does at its axis.
 * @param {Matrix} intrinsics
 */
export function axialMatrix(intrinsics) {
  const {
    camera_matrix: [[, , cx], [, , cy]],
  } = intrinsics;
  const [fx, fy] = focalLengths(intrinsics);
  return [
    [fx, 0, cx],
    [0, fy, cy],
    [0, 0, 1],
  ];
}

/**
 * Projection matrix of a scene over a picture: column-major, as in WebXR, three.js and `uniformMatrix4fv`. The
 * scene's camera looks along −z with y up: its frame is diag(1, −1, −1) of ours. Of a calibration with distortion it
 * is the pinhole that magnifies as the lens does at its axis.
 * @param {{img_size: readonly [number, number]} & Matrix} pinhole or calibration
 * @param {Frustum} [frustum]
 * @returns {number[]} 16 numbers
 */
export function projectionMatrix(
  pinhole,
  { near = 0.1, far = 1000, viewport = pinhole.img_size, fit = "cover", depth: [front, back] = [-1, 1] } = {},
) {
  const {
    img_size: size,
    camera_matrix: [[, , cx], [, , cy]],
  } = pinhole;
  const [fx, fy] = focalLengths(pinhole);
  // Of the device's coordinates, −1…1, a pixel.
  const [x, y] = scales(size, viewport, fit).map((scale, axis) => (2 * scale) / viewport[axis]);
  const a = (back - (front * near) / far) / (near / far - 1);
  return [
    x * fx,
    0,
    0,
    0,
    0,
    y * fy,
    0,
    0,
    x * ((size[0] - 1) / 2 - cx),
    y * (cy - (size[1] - 1) / 2),
    a,
    -1,
    0,
    0,
    near * (a + front),
    0,
  ];
}

/**
 * Scale of the picture in the viewport, along both axes.
 * @param {readonly [number, number]} size @param {readonly [number, number]} viewport @param {Fit} fit
 */
function scales(size, viewport, fit) {
  const ratios = size.map((side, axis) => viewport[axis] / side);
  if (fit === "fill") return ratios;
  const scale =
    fit === "none" ? 1 : fit === "cover" ? Math.max(...ratios) : Math.min(...ratios, fit === "contain" ? Infinity : 1);
  return [scale, scale];
}

/**
 * The same picture in another size.
 * @param {Pinhole} pinhole @param {number} scale
 * @returns {Pinhole}
 */
export function scalePinhole({ img_size: [width, height], camera_matrix: [[fx, , cx], [, fy, cy]] }, scale) {
  const size = /** @type {[number, number]} */ ([width, height].map((side) => Math.max(1, Math.round(side * scale))));
  const [sx, sy] = [size[0] / width, size[1] / height];
  return {
    img_size: size,
    camera_matrix: [
      [fx * sx, 0, (cx + 0.5) * sx - 0.5],
      [0, fy * sy, (cy + 0.5) * sy - 0.5],
      [0, 0, 1],
    ],
  };
}
