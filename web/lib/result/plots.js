// Plots of a result: predicted error, distortion, coverage, residuals. Numbers in, SVG out.
import { number, rough, t } from "../i18n.js";
import { above, valueAt } from "../contours.js";
import { coverage, displacements, viewIssue } from "./numbers.js";
import { arrow, imagePlot, make, short } from "../svg.js";

/**
 * @typedef {import("./numbers.js").Calibration} Calibration
 * @typedef {import("./numbers.js").Report} Report
 * @typedef {import("./numbers.js").ReportView} ReportView
 */

const HEAT_LEVELS = 8; // of the colour scale, see style.css
const MIN_SCALE_PX = 1e-3; // px; of the largest amount on a scale
const ROUNDOFF_PX = 1e-6; // px; what is moved by less is not moved
const ARROW_GRID = /** @type {[number, number]} */ ([17, 11]); // arrows of the distortion
const NOTABLE_DISTORTION = 0.02; // of the width; smaller distortions are drawn larger than they are

/** A round number not below. @param {number} value */
function roundUp(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return ([1, 1.2, 1.6, 2, 2.4, 3.2, 4, 5, 6, 8, 10].find((factor) => factor * power >= value * 0.999) ?? 10) * power;
}

/**
 * Typical error over the picture: bands between levels, and a reading of the value at any place.
 * @param {Calibration} calibration
 * @param {Report["error_map"] | null} map null: not there yet; the empty frame has the same size
 */
export function errorPlot({ img_size, uncertainty }, map) {
  // The same two numbers as everywhere: rms and maximum of this very map.
  const found = { typical: rough(uncertainty.rms), max: rough(uncertainty.max) };
  return { ...heatPlot(img_size, map?.px ?? null, uncertainty.max, t("result.error_label", found)), caption: t("result.error_caption", found) };
}

/**
 * Amounts over the picture.
 * @param {[number, number]} size px @param {import("../contours.js").Values | null} px null: an empty frame @param {number} max px @param {string} label
 */
export function heatPlot(size, px, max, label) {
  const top = roundUp(Math.max(max, MIN_SCALE_PX));
  const { svg, area, x, y } = imagePlot(size, label, { name: "heat" });
  if (px) area.append(...bandsOf(px, size, top, x, y));
  const at = (/** @type {MouseEvent} */ event) => {
    const box = area.getBoundingClientRect();
    const shares = [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
    const place = /** @type {[number, number]} */ (shares.map((share, axis) => share * size[axis] - 0.5));
    return px && shares.every((share) => share >= 0 && share <= 1) ? { place, value: valueAt(px, size, place) } : null;
  };
  return { svg, scale: scaleOf(top, Math.max(1, 1 - Math.floor(Math.log10(top)))), at };
}

/**
 * @param {import("../contours.js").Values} px @param {[number, number]} size px @param {number} top px @param {(u: number) => number} x
 * @param {(v: number) => number} y
 */
function bandsOf(px, size, top, x, y) {
  return Array.from({ length: HEAT_LEVELS }, (_, step) => {
    const polygons = above(px, size, step === 0 ? -Infinity : (top * step) / HEAT_LEVELS);
    const d = polygons.map((points) => `M${points.map(([u, v]) => `${short(x(u))} ${short(y(v))}`).join("L")}Z`).join("");
    return make("path", { d, class: `heat-${step}` });
  });
}

/** Rows of the map's values for a table, at the centres and the corners. @param {Calibration} calibration @param {Report["error_map"]} map */
export function errorTable({ img_size }, { px }) {
  const along = (/** @type {number} */ side) => [0, 0.25, 0.5, 0.75, 1].map((share) => Math.round(share * (side - 1)));
  const columns = along(img_size[0]);
  return { columns, rows: along(img_size[1]).map((v) => ({ v, values: columns.map((u) => valueAt(px, img_size, [u, v])) })) };
}

/** The colour scale with its numbers. @param {number} top px @param {number} digits */
function scaleOf(top, digits) {
  const svg = make("svg", { viewBox: "0 0 440 36", class: "plot heat", "aria-hidden": "true" });
  const width = (440 - 60) / HEAT_LEVELS;
  for (let step = 0; step < HEAT_LEVELS; step++) {
    svg.append(make("rect", { x: short(52 + step * width), y: 1, width: short(width + 0.3), height: 12, class: `heat-${step}` }));
  }
  for (let step = 0; step <= HEAT_LEVELS; step += 2) {
    const words = `${number((top * step) / HEAT_LEVELS, digits)}${step === HEAT_LEVELS ? " px" : ""}`;
    svg.append(make("text", { x: short(52 + step * width), y: 30, "text-anchor": step === HEAT_LEVELS ? "end" : step === 0 ? "start" : "middle" }, [words]));
  }
  return svg;
}

/**
 * Distortion over the image, as arrows from where a pinhole would show a ray.
 * @param {Calibration} calibration of a model that is known here
 */
export function distortionPlot(calibration) {
  const { img_size: [width, height], camera_matrix: [[, , cx], [, , cy]] } = calibration;
  const moves = displacements(calibration, ARROW_GRID);
  const largest = Math.max(0, ...moves.map(({ from, to }) => Math.hypot(from[0] - to[0], from[1] - to[1])));
  const scale = largest > NOTABLE_DISTORTION * width || largest < ROUNDOFF_PX ? 1 : 10 ** Math.ceil(Math.log10((NOTABLE_DISTORTION * width) / largest));
  const label = t("result.distortion_label", { max: number(largest, 1) });
  const { svg, area, x, y } = imagePlot([width, height], label, { name: "distortion" });
  const path = moves.map(({ from: [u, v], to: [p, q] }) => arrow(x(p + (u - p) * scale), y(q + (v - q) * scale), x(p), y(q))).join("");
  area.append(make("path", { d: path, class: "mark" }));
  area.append(make("path", { d: `M${short(x(cx) - 7)} ${short(y(cy))}h14M${short(x(cx))} ${short(y(cy) - 7)}v14`, class: "axis" }));
  const factor = scale === 1 ? "" : ` ${t("result.magnified", { factor: scale })}`;
  return { svg, caption: t("result.distortion_caption", { max: number(largest, 1) }) + factor };
}

/** All corners measured. @param {Calibration} calibration @param {Report | null} report null: not there yet */
export function coveragePlot({ img_size }, report) {
  const points = (report?.views ?? []).flatMap((view) => /** @type {number[][]} */ (view.points));
  const share = number(100 * coverage(points, img_size), 0);
  const { svg, area, x, y } = imagePlot(img_size, t("result.coverage_label", { share }), { name: "coverage" });
  area.append(make("path", { d: dots(points.map(([u, v]) => [x(u), y(v)])), class: "dot" }));
  return { svg, caption: report ? t("result.coverage_caption", { share, count: points.length }) : "\u00a0" };
}

/** @param {number[][]} points in plot units */
const dots = (points) => points.map(([u, v]) => `M${short(u)} ${short(v)}h.01`).join("");

/**
 * The residuals of one view, drawn larger than they are.
 * @param {Calibration} calibration @param {ReportView} view @param {ReportView[]} views @param {number} factor
 */
export function residualPlot({ img_size }, view, views, factor) {
  const what = viewIssue(view, views);
  const label = t("result.view_label", { index: view.index + 1, rms: number(view.rms, 2) });
  const { svg, area, x, y } = imagePlot(img_size, label, { plain: true, name: `residuals ${what ? "bad" : ""}` });
  const cut = new Set(view.cut);
  const lines = view.points.map((point, number) => {
    const [[u, v], [du, dv]] = /** @type {number[][]} */ ([point, view.residuals[number]]);
    return u === null || du === null ? null : { cut: view.reason !== null || cut.has(number), at: [x(u), y(v)], d: arrow(x(u), y(v), x(u + du * factor), y(v + dv * factor)) };
  }).filter((line) => line !== null);
  const path = (/** @type {boolean} */ which) => lines.filter((line) => line.cut === which).map(({ d }) => d).join("");
  area.append(make("path", { d: path(false), class: "mark" }), make("path", { d: dots(lines.map(({ at }) => at)), class: "dot" }));
  // A cross too: what was left out is not to be told by its colour alone.
  const crosses = lines.filter((line) => line.cut).map(({ at: [u, v] }) => `M${short(u - 3)} ${short(v - 3)}l6 6m0-6l-6 6`).join("");
  area.append(make("path", { d: path(true) + crosses, class: "cut" }));
  return svg;
}

/**
 * Scale of drawn residuals, the same for all views: a typical one is a 40th of the width.
 * @param {Calibration} calibration
 * @param {Report} report
 */
export function magnification({ img_size: [width] }, { views }) {
  const sorted = views.map(({ rms }) => rms).sort((a, b) => a - b);
  const typical = Math.max(sorted[Math.floor(sorted.length / 2)] ?? 0, 1e-3);
  return Math.max(1, Number((width / 40 / typical).toPrecision(1)));
}
