// Plots of the image plane as SVG, in the picture's frame.
import { make } from "./dom.js";

const WIDTH = 440; // units; pages show it at about that many CSS pixels

/** @param {number} value */
export const short = (value) => String(Math.round(value * 10) / 10);

/**
 * Round numbers from 0 to a length.
 * @param {number} length @param {number} most at most so many steps
 */
export function ticks(length, most) {
  const power = 10 ** Math.floor(Math.log10(length / most));
  const step = [1, 2, 4, 5, 10].map((factor) => factor * power).find((each) => length / each <= most) ?? length;
  return Array.from({ length: Math.floor(length / step + 1e-9) + 1 }, (_, index) => index * step);
}

/**
 * A frame of the picture's shape.
 * @param {readonly [number, number]} size px
 * @param {string} label for those who cannot see it
 * @param {string} [name] class
 * @returns {{svg: SVGElement, area: SVGElement, x: (u: number) => number, y: (v: number) => number}}
 *   area: clipped to the picture; x, y: px → plot
 */
export function imagePlot([width, height], label, name = "") {
  const unit = (WIDTH - 2) / width;
  const x = (/** @type {number} */ u) => 1 + (u + 0.5) * unit;
  const bottom = 1 + height * unit;
  const svg = make("svg", {
    viewBox: `0 0 ${WIDTH} ${short(bottom + 1)}`,
    role: "img",
    "aria-label": label,
    class: `plot ${name}`,
  });
  const frame = { x: 1, y: 1, width: WIDTH - 2, height: short(bottom - 1) };
  // One level of nesting clips what leaves the picture, without ids that several plots would share.
  const area = make("svg", { ...frame, viewBox: `1 1 ${frame.width} ${frame.height}`, overflow: "hidden" });
  svg.append(make("rect", { ...frame, class: "ground" }), area, make("rect", { ...frame, class: "edge" }));
  return { svg, area, x, y: x };
}

/** A line with a head of fixed size. @param {number} x0 @param {number} y0 @param {number} x1 @param {number} y1 */
export function arrow(x0, y0, x1, y1) {
  const [dx, dy] = [x1 - x0, y1 - y0];
  const length = Math.hypot(dx, dy);
  if (length < 0.5) return `M${short(x0)} ${short(y0)}h.1`;
  const head = Math.min(4, 0.45 * length) / length;
  const [hx, hy] = [dx * head, dy * head];
  return (
    `M${short(x0)} ${short(y0)}L${short(x1)} ${short(y1)}` +
    `M${short(x1 - hx + 0.5 * hy)} ${short(y1 - hy - 0.5 * hx)}L${short(x1)} ${short(y1)}` +
    `L${short(x1 - hx - 0.5 * hy)} ${short(y1 - hy + 0.5 * hx)}`
  );
}
