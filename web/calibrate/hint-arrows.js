// Arrows that illustrate an instruction, from the board to its target, in pixels of the camera's image.
import { middle, upright } from "../lib/capture/target.js";

/** @typedef {[x1: number, y1: number, x2: number, y2: number]} Arrow */

const MIN_LENGTH_PX = 14; // at 1280 px image width
const EDGES = ["tilt_top", "tilt_right", "tilt_bottom", "tilt_left"];

/**
 * @param {string} code of the instruction, about the camera's picture
 * @param {number[][] | null} outline of the board as seen @param {number[][] | null} aim of the target
 * @param {number} width of the image, px
 * @returns {Arrow[]} one between the centres to move the board; from its corners to turn it, tilt it or change its
 *   distance
 */
export function arrows(code, outline, aim, width) {
  if (!outline || !aim) return [];
  const seen = upright(outline, aim);
  if (/^(up|down|left|right)/.test(code)) return withoutShort([[...middle(seen), ...middle(aim)]], width);
  const ways = seen.map((from, index) => [...from, ...aim[index]]);
  if (code === "closer" || code === "farther" || code.startsWith("turn_")) return withoutShort(ways, width);
  const side = EDGES.indexOf(code);
  if (side < 0) return [];
  // The edge as it lies in the image: the board may be upside down.
  const value = (/** @type {number[]} */ [x, y]) => [-y, x, y, -x][side];
  const [a, b] = [0, 1, 2, 3].sort((i, j) => value(aim[j]) - value(aim[i]));
  return withoutShort([ways[a], ways[b]], width);
}

/** @param {number[][]} ways @param {number} width @returns {Arrow[]} */
function withoutShort(ways, width) {
  const shortest = (MIN_LENGTH_PX * width) / 1280;
  return /** @type {Arrow[]} */ (ways.filter(([x1, y1, x2, y2]) => Math.hypot(x2 - x1, y2 - y1) > shortest));
}
