// Chart of two amounts over time, one line each.
import { el, make } from "../lib/dom.js";
import { short, ticks } from "../lib/svg.js";

const [WIDTH, HEIGHT, LEFT, BOTTOM, TOP] = [640, 240, 48, 28, 10];
const MAX_LABELS = 6;

/**
 * @param {{date: string, cameras: number, known: number}[]} history oldest first, two at least
 * @param {string} label @param {[string, string]} names of the lines
 */
export function chart(history, label, names) {
  const times = history.map(({ date }) => Date.parse(date));
  const [first, last] = [times[0], times[times.length - 1]];
  const most = Math.max(1, ...history.map(({ cameras }) => cameras));
  const x = (/** @type {number} */ time) => LEFT + ((time - first) / Math.max(1, last - first)) * (WIDTH - LEFT - 8);
  const y = (/** @type {number} */ value) => HEIGHT - BOTTOM - (value / most) * (HEIGHT - BOTTOM - TOP);
  const svg = make("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": label, class: "chart" });
  for (const value of ticks(most, 4).map(Math.round)) {
    svg.append(
      make("path", { d: `M${LEFT} ${short(y(value))}H${WIDTH - 8}`, class: "rule" }),
      make("text", { x: LEFT - 8, y: short(y(value) + 4), "text-anchor": "end" }, [String(value)]),
    );
  }
  const step = Math.max(1, Math.ceil(history.length / MAX_LABELS));
  for (let index = 0; index < history.length; index += step) {
    svg.append(
      make(
        "text",
        {
          x: short(x(times[index])),
          y: HEIGHT - 8,
          "text-anchor": index === 0 ? "start" : index === history.length - 1 ? "end" : "middle",
        },
        [history[index].date.slice(0, 7)],
      ),
    );
  }
  for (const name of /** @type {const} */ (["cameras", "known"])) {
    const points = history.map((snapshot, index) => `${short(x(times[index]))},${short(y(snapshot[name]))}`).join(" ");
    svg.append(make("polyline", { points, class: `line ${name}` }));
  }
  const key = el(
    "figcaption",
    {},
    el("span", { class: "key cameras" }, names[0]),
    " ",
    el("span", { class: "key known" }, names[1]),
  );
  return el("figure", { class: "figure" }, svg, key);
}
