// Part of a result with its figures: where it errs, what the lens does, what was seen; each with a table of its values.
import { el } from "../dom.js";
import { number, rough, t } from "../i18n.js";
import { isKnownModel } from "../../sdk/projection.js";
import { coveragePlot, distortionPlot, errorPlot, errorTable } from "./plots.js";

/**
 * @typedef {import("./numbers.js").Calibration} Calibration
 * @typedef {import("./numbers.js").Report} Report
 */

/** @param {Calibration} calibration @param {Report | null} report @param {boolean} pending the report is on its way */
export function figuresPart(calibration, report, pending) {
  return el("div", { class: "figures" },
    ...(report || pending ? [titled("error", errorFigure(calibration, report?.error_map ?? null))] : []),
    ...(isKnownModel(calibration.distortion_model) ? [titled("distortion", figure(distortionPlot(calibration)))] : []),
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
  return el("details", {}, el("summary", {}, t("result.as_table")),
    el("table", { class: "values" }, el("caption", {}, t("result.error_table")),
      el("thead", {}, el("tr", {}, el("th", { scope: "col" }, "y \\ x, px"), ...columns.map((u) => el("th", { scope: "col", class: "number" }, String(u))))),
      el("tbody", {}, ...rows.map(({ v, values }) => el("tr", {}, el("th", { scope: "row" }, String(v)),
        ...values.map((value) => el("td", {}, value === null ? "–" : rough(value))))))));
}
