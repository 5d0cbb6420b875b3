// Faults of pictures, added to one: darkness, blur, moiré. With them pages are shown what they must diagnose.

/** @typedef {{width: number, height: number, data: Uint8ClampedArray}} Picture rgba, grey */

/** @type {Record<string, (value: number, x: number, y: number) => number>} */
const SHADES = {
  dark: (value) => value * 0.02,
  bright: (value) => 240 + value,
  moire: (value, x, y) => value * (0.8 + 0.2 * Math.sin(0.35 * x + 0.21 * y)),
};

/** Names of the faults. */
export const FAULTS = [...Object.keys(SHADES), "blurred", "mirrored"];

/** Adds a fault to a picture. @param {Picture} picture changed in place @param {string} fault */
export function degrade(picture, fault) {
  if (fault === "blurred") {
    for (const along of [1, picture.width, 1, picture.width]) smear(picture, 13, along);
    return;
  }
  if (fault === "mirrored") return mirror(picture);
  const shade = SHADES[fault];
  if (!shade) return;
  const { width, data } = picture;
  for (let at = 0; at < data.length; at += 4) {
    const pixel = at >> 2;
    data[at] = data[at + 1] = data[at + 2] = shade(data[at], pixel % width, Math.floor(pixel / width));
  }
}

/**
 * The mean of `span` neighbours in one direction: what a moving camera does while its shutter is open.
 * @param {Picture} picture changed in place
 * @param {number} span px, odd or not
 * @param {number} along 1 across, the width down
 */
export function smear({ width, height, data }, span, along) {
  const [lines, length, next] = along === 1 ? [height, width, width] : [width, height, 1];
  const half = span >> 1;
  const line = new Uint8Array(length);
  for (let index = 0; index < lines; index++) {
    const start = 4 * index * next;
    for (let i = 0; i < length; i++) line[i] = data[start + 4 * i * along];
    const value = (/** @type {number} */ i) => line[Math.min(length - 1, Math.max(0, i))];
    let sum = 0;
    for (let i = -half; i < span - half; i++) sum += value(i);
    for (let i = 0; i < length; i++) {
      const at = start + 4 * i * along;
      data[at] = data[at + 1] = data[at + 2] = sum / span;
      sum += value(i + span - half) - value(i - half);
    }
  }
}

/** @param {Picture} picture */
function mirror({ width, height, data }) {
  const pixels = new Uint32Array(data.buffer, data.byteOffset, data.byteLength / 4);
  for (let y = 0; y < height; y++) pixels.subarray(y * width, (y + 1) * width).reverse();
}
