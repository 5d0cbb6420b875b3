// Texts as pictures, for files whose fonts have no letters for them.

/** @typedef {import("./board-pdf.js").Lettering} Lettering */

const SIZE = 64; // px; 576 a inch for letters of 8 points
const FONT = `${SIZE}px Helvetica, Arial, "Liberation Sans", sans-serif`;

/** @param {string} text @returns {Lettering | null} null: this browser draws nothing */
export function lettering(text) {
  const canvas = document.createElement("canvas");
  const before = canvas.getContext("2d");
  if (!before) return null;
  before.font = FONT;
  const bytes = Math.ceil(before.measureText(text).width / 8);
  [canvas.width, canvas.height] = [8 * bytes, Math.ceil(1.4 * SIZE)];
  const depth = Math.round(0.35 * SIZE);
  const context = canvas.getContext("2d", { willReadFrequently: true });
  if (!context) return null;
  context.font = FONT; // another size of the canvas forgets it
  context.fillText(text, 0, canvas.height - depth);
  const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
  const bits = new Uint8Array(bytes * canvas.height).fill(255);
  for (let pixel = 0; pixel < canvas.width * canvas.height; pixel++) {
    if (data[4 * pixel + 3] > 127) bits[pixel >> 3] &= ~(128 >> (pixel & 7));
  }
  return { width: canvas.width, height: canvas.height, size: SIZE, depth, bits };
}
