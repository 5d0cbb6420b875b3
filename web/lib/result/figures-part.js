// Part of a result with its figures: where it errs, what the lens does, what was seen; each with a table of its values.
import { el } from "../dom.js";
import { number, rough, t } from "../i18n.js";
import { isKnownModel } from "../../sdk/projection.js";
import { displacements } from "./numbers.js";
import { coveragePlot, distortionPlot, errorPlot, errorTable } from "./plots.js";

/**
 * @typedef {import("./numbers.js").Calibration} Calibration
 * @typedef {import("./numbers.js").Report} Report
 */

const TABLE_GRID = /** @type {[number, number]} */ ([5, 5]); // columns and rows of values

/** @param {Calibration} calibration @param {Report | null} report @param {boolean} pending the report is on its way */
export function figuresPart(calibration, report, pending) {
  return el("div", { class: "figures" },
    ...(report || pending ? [titled("error", errorFigure(calibration, report?.error_map ?? null))] : []),
    ...(isKnownModel(calibration.distortion_model) ? [titled("distortion", figure(distortionPlot(calibration), distortionValues(calibration)))] : []),
    ...(report || pending ? [titled("coverage", figure(coveragePlot(calibration, report)))] : []));
}

/** @param {"error" | "distortion" | "coverage"} name @param {Node} content */
const titled = (name, content) => el("section", { "aria-labelledby": `result-${name}` }, el("h3", { id: `result-${name}` }, t(`result.part_${name}`)), content);

/** @param {{svg: Node, caption: string, scale?: Node}} made @param {Node[]} more */
export function figure({ svg, caption, scale }, ...more) {
  return el("figure", { class: "figure measured" }, svg, ...(scale ? [scale] : []), el("figcaption", {}, caption), ...more);
}

/** @param {Calibration} calibration @param {Report["error_map"] | null} map */
function errorFigure(calibration, map) {
  const made = errorPlot(calibration, map);
  return figure(made, reading(made), ...(map ? [errorValues(calibration, map)] : []));
}

/** The amount at the place that one points at. @param {ReturnType<typeof import("./plots.js").heatPlot>} made */
export function reading({ svg, at }) {
  const place = el("p", { class: "reading muted number" }, t("result.error_point"));
  const read = (/** @type {Event} */ event) => {
    const found = at(/** @type {MouseEvent} */ (event));
    place.textContent = found && found.value !== null
      ? t("result.error_at", { x: number(found.place[0], 0), y: number(found.place[1], 0), error: rough(found.value) }) : t("result.error_point");
  };
  for (const name of ["pointermove", "pointerdown", "pointerleave"]) svg.addEventListener(name, read);
  return place;
}

/** @param {Calibration} calibration @param {Report["error_map"]} map */
function errorValues(calibration, map) {
  const { columns, rows } = errorTable(calibration, map);
  return valuesTable(t("result.error_table"), columns, rows);
}

/** @param {Calibration} calibration */
function distortionValues(calibration) {
  const moves = displacements(calibration, TABLE_GRID);
  const middles = [0, 1].map((axis) => Array.from({ length: TABLE_GRID[axis] }, (_, index) => ((index + 0.5) * calibration.img_size[axis]) / TABLE_GRID[axis] - 0.5));
  const at = (/** @type {number} */ u, /** @type {number} */ v) => moves.find(({ to }) => Math.abs(to[0] - u) < 1e-6 && Math.abs(to[1] - v) < 1e-6);
  const length = (/** @type {ReturnType<typeof at>} */ move) => (move ? Math.hypot(move.to[0] - move.from[0], move.to[1] - move.from[1]) : null);
  return valuesTable(t("result.distortion_table"), middles[0].map(Math.round), middles[1].map((v) => ({ v: Math.round(v), values: middles[0].map((u) => length(at(u, v))) })));
}

/** @param {string} caption @param {number[]} columns px @param {{v: number, values: (number | null)[]}[]} rows */
function valuesTable(caption, columns, rows) {
  return el("details", {}, el("summary", {}, t("result.as_table")),
    el("table", { class: "values" }, el("caption", {}, caption),
      el("thead", {}, el("tr", {}, el("th", { scope: "col" }, "y \\ x, px"), ...columns.map((u) => el("th", { scope: "col", class: "number" }, String(u))))),
      el("tbody", {}, ...rows.map(({ v, values }) => el("tr", {}, el("th", { scope: "row" }, String(v)),
        ...values.map((value) => el("td", {}, value === null ? "–" : rough(value))))))));
}
