// Saddle points of an image: places where two black and two white areas meet, as at the corners of a chessboard. Pure.

/** @import { Grey } from "./subpixel.js" */

/**
 * @typedef {object} Saddle
 * @property {number} x px, pixel centres at whole numbers
 * @property {number} y
 * @property {number} strength response of the detector
 * @property {number} axis direction of the white areas, rad, 0 to π
 * @property {number} contrast between white and black on the ring, of 255
 */

// ChESS (Bennett & Lasenby, "ChESS: quick and robust detection of chess-board features", 2014): 16 samples on a ring.
const RING = [
  [0, -5],
  [2, -5],
  [3, -3],
  [5, -2],
  [5, 0],
  [5, 2],
  [3, 3],
  [2, 5],
  [0, 5],
  [-2, 5],
  [-3, 3],
  [-5, 2],
  [-5, 0],
  [-5, -2],
  [-3, -3],
  [-2, -5],
];
const RING_RADIUS_PX = 5;
const MIN_RESPONSE = 60; // of 255 grey levels: four pairs of samples that differ by 15
const MIN_RELATIVE_RESPONSE = 0.06; // of the strongest ones: a board's corners are about equally strong
const SUPPRESSION_PX = 4; // px: weaker points so near are the same one
const MAX_SADDLES = 6000;

/** @param {Grey} image @returns {Saddle[]} strongest first */
export function saddlePoints(image) {
  const { width, height, data } = image;
  const response = new Float32Array(width * height);
  const offsets = Int32Array.from(RING.map(([x, y]) => y * width + x));
  const [o0, o1, o2, o3, o4, o5, o6, o7, o8, o9, o10, o11, o12, o13, o14, o15] = offsets;
  /** @type {number[]} */
  const found = [];
  for (let y = RING_RADIUS_PX; y < height - RING_RADIUS_PX; y++) {
    for (let x = RING_RADIUS_PX, at = y * width + x; x < width - RING_RADIUS_PX; x++, at++) {
      const [a, b, c, d] = [
        data[at + o0] + data[at + o8],
        data[at + o4] + data[at + o12],
        data[at + o2] + data[at + o10],
        data[at + o6] + data[at + o14],
      ];
      const first = Math.abs(a - b) + Math.abs(c - d);
      if (first < MIN_RESPONSE / 3) continue; // most of a picture is none
      const [e, f, g, h] = [
        data[at + o1] + data[at + o9],
        data[at + o5] + data[at + o13],
        data[at + o3] + data[at + o11],
        data[at + o7] + data[at + o15],
      ];
      const sum = first + Math.abs(e - f) + Math.abs(g - h);
      const difference =
        Math.abs(data[at + o0] - data[at + o8]) +
        Math.abs(data[at + o1] - data[at + o9]) +
        Math.abs(data[at + o2] - data[at + o10]) +
        Math.abs(data[at + o3] - data[at + o11]) +
        Math.abs(data[at + o4] - data[at + o12]) +
        Math.abs(data[at + o5] - data[at + o13]) +
        Math.abs(data[at + o6] - data[at + o14]) +
        Math.abs(data[at + o7] - data[at + o15]);
      if (sum - difference < MIN_RESPONSE) continue;
      const mean = (a + b + c + d + e + f + g + h) / 16;
      const local = (data[at] + data[at - 1] + data[at + 1] + data[at - width] + data[at + width]) / 5;
      const value = sum - difference - 16 * Math.abs(local - mean);
      if (value < MIN_RESPONSE) continue;
      response[at] = value;
      found.push(at);
    }
  }
  const peaks = found
    .filter((at) => isPeak(response, at, width))
    .map((at) => describe(image, response[at], at % width, Math.floor(at / width)));
  peaks.sort((p, q) => q.strength - p.strength);
  const typical = peaks[Math.min(peaks.length - 1, 20)]?.strength ?? 0;
  return peaks.filter(({ strength }) => strength >= MIN_RELATIVE_RESPONSE * typical).slice(0, MAX_SADDLES);
}

/** @param {Float32Array} response @param {number} at @param {number} width */
function isPeak(response, at, width) {
  for (let y = -SUPPRESSION_PX; y <= SUPPRESSION_PX; y++) {
    for (let x = -SUPPRESSION_PX; x <= SUPPRESSION_PX; x++) {
      const other = response[at + y * width + x];
      if (other > response[at] || (other === response[at] && (y < 0 || (y === 0 && x < 0)))) return false;
    }
  }
  return true;
}

/** @param {Grey} image @param {number} strength @param {number} x @param {number} y whole pixels @returns {Saddle} */
export function describe({ width, data }, strength, x, y) {
  let [cosine, sine] = [0, 0];
  const samples = RING.map(([dx, dy]) => data[(y + dy) * width + x + dx]);
  RING.forEach(([dx, dy], index) => {
    const angle = 2 * Math.atan2(dy, dx);
    cosine += samples[index] * Math.cos(angle);
    sine += samples[index] * Math.sin(angle);
  });
  samples.sort((a, b) => a - b);
  const axis = Math.atan2(sine, cosine) / 2;
  return { x, y, strength, axis: axis < 0 ? axis + Math.PI : axis, contrast: samples[12] - samples[3] };
}

/**
 * Response of the detector at one pixel, of either sign.
 * @param {Grey} image
 * @param {number} x
 * @param {number} y whole pixels
 */
export function responseAt({ width, data }, x, y) {
  const at = y * width + x;
  const ring = RING.map(([dx, dy]) => data[at + dy * width + dx]);
  let [sum, difference] = [0, 0];
  for (let n = 0; n < 4; n++) sum += Math.abs(ring[n] + ring[n + 8] - ring[n + 4] - ring[n + 12]);
  for (let n = 0; n < 8; n++) difference += Math.abs(ring[n] - ring[n + 8]);
  const local = (data[at] + data[at - 1] + data[at + 1] + data[at - width] + data[at + width]) / 5;
  return sum - difference - 16 * Math.abs(local - ring.reduce((total, value) => total + value, 0) / 16);
}

/** True if all of the ring lies in the image. @param {Grey} image @param {number} x @param {number} y */
export function hasRing({ width, height }, x, y) {
  return x >= RING_RADIUS_PX && y >= RING_RADIUS_PX && x < width - RING_RADIUS_PX && y < height - RING_RADIUS_PX;
}
