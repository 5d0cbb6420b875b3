// Arrows that show an instruction: from where the board is to where it is to be. Pixels of the camera's picture.
import { middle, upright } from "./target.js";

/** @typedef {[x1: number, y1: number, x2: number, y2: number]} Arrow */

const SHORTEST = 14; // px at 1280 px image width; below that an arrow is a blot
const EDGES = ["tilt_top", "tilt_right", "tilt_bottom", "tilt_left"];

/**
 * @param {string} code of the instruction, about the camera's picture
 * @param {number[][] | null} outline of the board as seen @param {number[][] | null} aim of the target
 * @param {number} width of the image, px
 * @returns {Arrow[]} one from middle to middle to move it; from its corners to turn it, to tilt it, to bring it closer
 */
export function arrows(code, outline, aim, width) {
  if (!outline || !aim) return [];
  const seen = upright(outline, aim);
  if (/^(up|down|left|right)/.test(code)) return long([[...middle(seen), ...middle(aim)]], width);
  const ways = seen.map((from, index) => [...from, ...aim[index]]);
  if (code === "closer" || code === "farther" || code.startsWith("turn_")) return long(ways, width);
  const side = EDGES.indexOf(code);
  if (side < 0) return [];
  // The edge as it lies in the picture, not as it is named on a board that may be upside down.
  const value = (/** @type {number[]} */ [x, y]) => [-y, x, y, -x][side];
  const [a, b] = [0, 1, 2, 3].sort((i, j) => value(aim[j]) - value(aim[i]));
  return long([ways[a], ways[b]], width);
}

/** @param {number[][]} ways @param {number} width @returns {Arrow[]} */
function long(ways, width) {
  const shortest = (SHORTEST * width) / 1280;
  return /** @type {Arrow[]} */ (ways.filter(([x1, y1, x2, y2]) => Math.hypot(x2 - x1, y2 - y1) > shortest));
}
