// Agreement among the calibrations of one camera: plots of focal lengths and principal points, their spread, and the
// ring that counts them.
import { dateText, number, t } from "../lib/i18n.js";
import { make } from "../lib/dom.js";
import { short } from "../lib/svg.js";

/**
 * @typedef {object} Member one calibration
 * @property {string} id
 * @property {number} time unix seconds
 * @property {number} fx px
 * @property {number} fy
 * @property {number} cx
 * @property {number} cy
 * @property {number} rms px
 * @property {string} model
 * @property {boolean} in_group does it agree with most of the others?
 */

const [WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM] = [360, 230, 58, 12, 10, 40];
const MIN_RELATIVE_SPAN = 0.02; // of the value: smaller differences are not blown up to fill the plot

/**
 * The range of an axis, and round numbers in it.
 * @param {number[]} values @param {number} least width
 */
export function axis(values, least) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const pad = Math.max(least - (high - low), 0.16 * (high - low)) / 2;
  const [from, to] = [low - pad, high + pad];
  const raw = (to - from) / 5;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((each) => each >= raw * 0.999) ?? raw;
  const first = Math.ceil(from / step - 1e-9);
  const last = Math.floor(to / step + 1e-9);
  return {
    from,
    to,
    digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)),
    ticks: Array.from({ length: last - first + 1 }, (_, index) => (first + index) * step),
  };
}

/** @typedef {ReturnType<typeof axis>} Axis */

/**
 * @param {Axis} across
 * @param {Axis | null} names no numbers where null
 * @param {Axis} up
 * @param {string} label
 * @param {string} x
 * @param {string} y
 */
function frame(across, names, up, label, x, y) {
  const at = {
    x: (/** @type {number} */ value) =>
      LEFT + ((value - across.from) / (across.to - across.from)) * (WIDTH - LEFT - RIGHT),
    y: (/** @type {number} */ value) =>
      HEIGHT - BOTTOM - ((value - up.from) / (up.to - up.from)) * (HEIGHT - TOP - BOTTOM),
  };
  const svg = make("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "group", "aria-label": label, class: "plot" });
  svg.append(
    make("rect", { x: LEFT, y: TOP, width: WIDTH - LEFT - RIGHT, height: HEIGHT - TOP - BOTTOM, class: "ground" }),
  );
  for (const value of up.ticks) {
    svg.append(
      make("path", { d: `M${LEFT} ${short(at.y(value))}H${WIDTH - RIGHT}`, class: "grid" }),
      make("text", { x: LEFT - 7, y: short(at.y(value) + 4), "text-anchor": "end" }, [number(value, up.digits)]),
    );
  }
  for (const value of names?.ticks ?? []) {
    svg.append(
      make("path", { d: `M${short(at.x(value))} ${HEIGHT - BOTTOM}v5`, class: "tick" }),
      make("text", { x: short(at.x(value)), y: HEIGHT - BOTTOM + 18, "text-anchor": "middle" }, [
        number(value, across.digits),
      ]),
    );
  }
  svg.append(
    make("rect", { x: LEFT, y: TOP, width: WIDTH - LEFT - RIGHT, height: HEIGHT - TOP - BOTTOM, class: "edge" }),
    make("text", { x: LEFT + (WIDTH - LEFT - RIGHT) / 2, y: HEIGHT - 5, "text-anchor": "middle" }, [x]),
    make(
      "text",
      {
        x: 12,
        y: TOP + (HEIGHT - TOP - BOTTOM) / 2,
        "text-anchor": "middle",
        transform: `rotate(-90 12 ${TOP + (HEIGHT - TOP - BOTTOM) / 2})`,
      },
      [y],
    ),
  );
  return { svg, at };
}

/**
 * A dot for what agrees, a cross for what does not; a link to its page. The table next to the plots has the same links
 * for the keyboard.
 * @param {number} x @param {number} y @param {Member} member
 */
function mark(x, y, { id, time, fx, in_group: agrees }) {
  const text = t("cameras.dot", { date: dateText(time), fx: number(fx, 1) });
  return make("a", { href: `../result/?${new URLSearchParams({ id })}`, tabindex: -1, "aria-label": text }, [
    make("title", {}, [text]),
    make("circle", { cx: short(x), cy: short(y), r: 16, class: "touch" }),
    agrees
      ? make("circle", { cx: short(x), cy: short(y), r: 3.4, class: "agrees" })
      : make("path", { d: `M${short(x - 4)} ${short(y - 4)}l8 8m0-8l-8 8`, class: "cut" }),
  ]);
}

/** Focal lengths, oldest first. @param {Member[]} members @param {number | null} agreed px */
export function focalPlot(members, agreed) {
  const sorted = [...members].sort((a, b) => a.time - b.time);
  const values = [...sorted.map(({ fx }) => fx), ...(agreed === null ? [] : [agreed])];
  const up = axis(values, MIN_RELATIVE_SPAN * values[0]);
  const across = { from: 0, to: sorted.length + 1, digits: 0, ticks: [] };
  const label = t("cameras.focal_label", { low: number(Math.min(...values), 0), high: number(Math.max(...values), 0) });
  const { svg, at } = frame(across, null, up, label, t("cameras.in_order"), "fx, px");
  if (agreed !== null)
    svg.append(make("path", { d: `M${LEFT} ${short(at.y(agreed))}H${WIDTH - RIGHT}`, class: "agreed" }));
  svg.append(...sorted.map((member, index) => mark(at.x(index + 1), at.y(member.fx), member)));
  return svg;
}

/** Principal points. @param {Member[]} members @param {[number, number] | null} agreed px */
export function centrePlot(members, agreed) {
  const points = [...members.map(({ cx, cy }) => [cx, cy]), ...(agreed ? [agreed] : [])];
  const [across, up] = [0, 1].map((coordinate) =>
    axis(
      points.map((point) => point[coordinate]),
      0.02 * points[0][0],
    ),
  );
  const { svg, at } = frame(across, across, up, t("cameras.centre_label"), "cx, px", "cy, px");
  svg.append(...members.map((member) => mark(at.x(member.cx), at.y(member.cy), member)));
  if (agreed) {
    const [x, y] = [at.x(agreed[0]), at.y(agreed[1])];
    svg.append(make("path", { d: `M${short(x - 9)} ${short(y)}h18M${short(x)} ${short(y - 9)}v18`, class: "agreed" }));
  }
  return svg;
}

const RING = 7; // units: radius
const GAP = 0.12; // between two parts of the ring, as a share of a part

/**
 * Ring with a part for each calibration that is needed.
 * @param {{agreeing: number, required: number}} size
 */
export function ring({ agreeing, required }) {
  const parts = Array.from({ length: required }, (_, index) =>
    make("circle", {
      cx: 10,
      cy: 10,
      r: RING,
      pathLength: required,
      class: index < agreeing ? "there" : "",
      "stroke-dasharray": `${1 - GAP} ${required - 1 + GAP}`,
      "stroke-dashoffset": String(required / 4 - index - GAP / 2),
    }),
  );
  return make("svg", { viewBox: "0 0 20 20", class: "ring", "aria-hidden": "true" }, parts);
}

/**
 * Standard deviations between calibrations by one model; distortion coefficients are not compared: they trade off.
 * @param {Member[]} members @param {string} model
 * @returns {{count: number, fx: number, fy: number, cx: number, cy: number, distortion: (number | null)[]} | null} px;
 *   null: fewer than two
 */
export function spreadOf(members, model) {
  const agreeing = members.filter((member) => member.in_group && member.model === model);
  if (agreeing.length < 2) return null;
  const deviation = (/** @type {"fx" | "fy" | "cx" | "cy"} */ name) => {
    const mean = agreeing.reduce((sum, member) => sum + member[name], 0) / agreeing.length;
    return Math.sqrt(agreeing.reduce((sum, member) => sum + (member[name] - mean) ** 2, 0) / (agreeing.length - 1));
  };
  return {
    count: agreeing.length,
    fx: deviation("fx"),
    fy: deviation("fy"),
    cx: deviation("cx"),
    cy: deviation("cy"),
    distortion: [],
  };
}
