// A grid through a lens, drawn with the lens model that the rest of calibDB uses.
import { project } from "./virtual/lens.js";

/** @typedef {import("./virtual/lens.js").Lens} Lens */

/**
 * Grid lines in pixels, as points along each.
 * @param {Lens} lens @param {[number, number]} size px @param {number} step px between lines
 * @returns {[number, number][][]}
 */
export function gridThrough(lens, [width, height], step) {
  const pinhole = { fx: lens.fx, fy: lens.fy, cx: lens.cx, cy: lens.cy };
  const bend = (/** @type {number} */ x, /** @type {number} */ y) =>
    project(lens, [(x - pinhole.cx) / pinhole.fx, (y - pinhole.cy) / pinhole.fy, 1]);
  /** @type {[number, number][][]} */
  const lines = [];
  for (let x = 0; x <= width; x += step) lines.push(range(height, step / 4).map((y) => bend(x, y)));
  for (let y = 0; y <= height; y += step) lines.push(range(width, step / 4).map((x) => bend(x, y)));
  return lines;
}

/** @param {number} end @param {number} step */
const range = (end, step) => Array.from({ length: Math.floor(end / step) + 1 }, (_, index) => index * step);

/** @param {Element} svg @param {[number, number][]} points @param {string} name class */
export function drawLine(svg, points, name) {
  const line = svg.ownerDocument.createElementNS("http://www.w3.org/2000/svg", "polyline");
  line.setAttribute("points", points.map((point) => point.map((value) => value.toFixed(1)).join(",")).join(" "));
  line.setAttribute("class", name);
  svg.append(line);
}
