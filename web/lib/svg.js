// Plots of the image plane as SVG: the picture's frame with its axes in pixels.

const SVG = "http://www.w3.org/2000/svg";
const WIDTH = 440; // units; pages show it at about that many CSS pixels, so that its letters are as large as they say
const LEFT_MARGIN = 52;
const BOTTOM_MARGIN = 34;
const EDGE_MARGIN = 8; // half a label

/**
 * @param {string} name @param {Record<string, string | number>} [attributes] @param {(Node | string)[]} [content]
 * @returns {SVGElement}
 */
export function make(name, attributes = {}, content = []) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, String(value));
  made.append(...content);
  return made;
}

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
 * A frame of the picture's shape, axes in px.
 * @param {[number, number]} size px @param {string} label for those who cannot see it @param {{plain?: boolean, name?: string}} [options] plain: without numbers
 * @returns {{svg: SVGElement, area: SVGElement, x: (u: number) => number, y: (v: number) => number, unit: number}}
 *   area: clipped to the picture; x, y: px → plot; unit: plot units a pixel
 */
export function imagePlot([width, height], label, { plain = false, name = "" } = {}) {
  const left = plain ? 1 : LEFT_MARGIN;
  const unit = (WIDTH - left - (plain ? 1 : EDGE_MARGIN)) / width;
  const x = (/** @type {number} */ u) => left + (u + 0.5) * unit;
  const y = (/** @type {number} */ v) => EDGE_MARGIN + (v + 0.5) * unit;
  const [right, bottom] = [x(width - 0.5), y(height - 0.5)];
  const svg = make("svg", {
    viewBox: `0 0 ${WIDTH} ${short(bottom + (plain ? 1 : BOTTOM_MARGIN))}`, role: "img", "aria-label": label, class: `plot ${name}`,
  });
  const frame = { x: short(left), y: EDGE_MARGIN, width: short(right - left), height: short(bottom - EDGE_MARGIN) };
  // One level of nesting clips what leaves the picture, without ids that several plots would share.
  const area = make("svg", { ...frame, viewBox: `${frame.x} ${frame.y} ${frame.width} ${frame.height}`, overflow: "hidden" });
  svg.append(make("rect", { ...frame, class: "ground" }), area, make("rect", { ...frame, class: "edge" }));
  if (!plain) {
    const text = (/** @type {number} */ at, /** @type {number} */ height, /** @type {string} */ anchor, /** @type {string} */ words) =>
      make("text", { x: short(at), y: short(height), "text-anchor": anchor }, [words]);
    for (const u of ticks(width, 5)) {
      svg.append(make("path", { d: `M${short(x(u - 0.5))} ${short(bottom)}v5`, class: "tick" }), text(x(u - 0.5), bottom + 17, "middle", String(u)));
    }
    for (const v of ticks(height, 4)) {
      svg.append(make("path", { d: `M${left} ${short(y(v - 0.5))}h-5`, class: "tick" }), text(left - 8, y(v - 0.5) + 4, "end", String(v)));
    }
    svg.append(text(left + (right - left) / 2, bottom + 31, "middle", "x, px"));
    const middle = EDGE_MARGIN + (bottom - EDGE_MARGIN) / 2;
    svg.append(make("text", { x: 12, y: short(middle), "text-anchor": "middle", transform: `rotate(-90 12 ${short(middle)})` }, ["y, px"]));
  }
  return { svg, area, x, y, unit };
}

/** A line with a head of fixed size. @param {number} x0 @param {number} y0 @param {number} x1 @param {number} y1 */
export function arrow(x0, y0, x1, y1) {
  const [dx, dy] = [x1 - x0, y1 - y0];
  const length = Math.hypot(dx, dy);
  if (length < 0.5) return `M${short(x0)} ${short(y0)}h.1`;
  const head = Math.min(4, 0.45 * length) / length;
  const [hx, hy] = [dx * head, dy * head];
  return `M${short(x0)} ${short(y0)}L${short(x1)} ${short(y1)}` +
    `M${short(x1 - hx + 0.5 * hy)} ${short(y1 - hy - 0.5 * hx)}L${short(x1)} ${short(y1)}L${short(x1 - hx - 0.5 * hy)} ${short(y1 - hy + 0.5 * hx)}`;
}
