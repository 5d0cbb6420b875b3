// Figure of a grid seen through a lens, by the SDK's lens models.
import { axialMatrix } from "../sdk/pinhole.js";
import { lensOf } from "../sdk/projection.js";

/** @typedef {import("../sdk/projection.js").Intrinsics} Intrinsics */

const SVG = "http://www.w3.org/2000/svg";

/**
 * Lines of a regular grid of the scene, as the lens shows them.
 * @param {Intrinsics} intrinsics @param {[number, number]} size px @param {number} step px between lines
 * @returns {[number, number][][]} px, points along each
 */
export function gridThrough(intrinsics, [width, height], step) {
  const [[fx, , cx], [, fy, cy]] = axialMatrix(intrinsics);
  const lens = lensOf(intrinsics);
  const bend = (/** @type {number} */ x, /** @type {number} */ y) => lens.project([(x - cx) / fx, (y - cy) / fy, 1]);
  /** @type {([number, number] | null)[][]} */
  const lines = [];
  for (let x = 0; x <= width; x += step) lines.push(range(height, step / 4).map((y) => bend(x, y)));
  for (let y = 0; y <= height; y += step) lines.push(range(width, step / 4).map((x) => bend(x, y)));
  return lines.map((line) => line.filter((point) => point !== null));
}

/** @param {number} end @param {number} step */
const range = (end, step) => Array.from({ length: Math.floor(end / step) + 1 }, (_, index) => index * step);

/** @param {Element} svg @param {[number, number][]} points @param {string} name class */
export function drawLine(svg, points, name) {
  const line = svg.ownerDocument.createElementNS(SVG, "polyline");
  line.setAttribute("points", points.map((point) => point.map((value) => value.toFixed(1)).join(",")).join(" "));
  line.setAttribute("class", name);
  svg.append(line);
}
