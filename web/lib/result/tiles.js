// Tiles of a result: how accurate it is where, what the boards have covered, and where they were; and figures that
// other pages share.
import { el, make } from "../dom.js";
import { number, rough, t } from "../i18n.js";
import { sceneOf, scenePlot } from "../scene-plot.js";
import { isKnownModel } from "../../sdk/projection.js";
import { displacements } from "./numbers.js";
import { coveragePlot, errorPlot, errorTable } from "./plots.js";

/**
 * @import { Board } from "../board.js"
 * @import { Calibration, Report } from "./numbers.js"
 */

const TABLE_GRID = /** @type {[number, number]} */ ([5, 5]); // columns and rows of values
const CAMERA = { position: 0, rvec: [0, 0, 0], tvec: [0, 0, 0] };

/**
 * @param {Calibration} calibration
 * @param {Report | null} report null: on its way
 * @param {Board | null} board null: not known, or not yet
 */
export function tiles(calibration, report, board) {
  const tile = (/** @type {string} */ name, /** @type {Node} */ content) =>
    el(
      "section",
      { class: "tile", "aria-labelledby": `result-${name}` },
      el("h2", { id: `result-${name}` }, t(`result.part_${name}`)),
      content,
    );
  return el(
    "div",
    { class: report ? "tiles" : "tiles pending", role: "group", tabindex: 0, "aria-label": t("result.part_figures") },
    tile("error", figure(errorPlot(calibration, report), errorValues(calibration, report))),
    tile("coverage", figure(coveragePlot(calibration, report))),
    isKnownModel(calibration.distortion_model) &&
      (board || !report) &&
      tile("poses", poses(calibration, report, board)),
  );
}

/** @param {Calibration} calibration @param {Report | null} report @param {Board | null} board */
function poses(calibration, report, board) {
  const views = (board && report?.views) || [];
  const empty = make("svg", { viewBox: "0 0 400 225", class: "scene", "aria-hidden": "true" });
  return el(
    "figure",
    { class: "figure" },
    board && views.length
      ? scenePlot(
          sceneOf([calibration], [CAMERA], views, board, 1),
          t("result.poses_label", { count: views.length }),
          views.map(({ index }) => index),
        )
      : empty,
    el("figcaption", {}, t("result.poses_caption")),
  );
}

/**
 * @param {{svg: Node, caption: string, levels?: number[], at?: ReturnType<typeof
 *   import("./plots.js").heatPlot>["at"]}} made levels: px, of the colours; at: the amount at a place, which the
 *   caption says while one points there
 * @param {Node[]} more
 */
export function figure({ svg, caption, levels, at }, ...more) {
  const words = el("figcaption", { class: "number" }, caption);
  const read = (/** @type {Event} */ event) => {
    const found = at?.(/** @type {MouseEvent} */ (event));
    words.textContent =
      found && found.value !== null
        ? t("result.error_at", {
            x: number(found.place[0], 0),
            y: number(found.place[1], 0),
            error: rough(found.value),
          })
        : caption;
  };
  if (at) for (const name of ["pointermove", "pointerdown", "pointerleave"]) svg.addEventListener(name, read);
  return el("figure", { class: "figure measured" }, svg, levels && scaleOf(levels), words, ...more);
}

/** The colour scale with the numbers between its colours. @param {number[]} levels px */
function scaleOf(levels) {
  const last = levels.length - 1;
  return el(
    "div",
    { class: "scale number", "aria-hidden": "true" },
    el("div", {}, ...levels.slice(0, -1).map((_, step) => el("i", { class: `heat-${step}` }))),
    el(
      "div",
      {},
      ...levels.flatMap((level, step) =>
        step % 2 ? [] : [el("span", {}, step ? `${rough(level)}${step === last ? "\u00a0px" : ""}` : "0")],
      ),
    ),
  );
}

/** @param {Calibration} calibration @param {Report | null} report */
function errorValues(calibration, report) {
  const { columns, rows } = errorTable(calibration, report);
  return el(
    "details",
    {},
    el("summary", {}, t("result.as_table")),
    valuesTable(t("result.error_table"), columns, rows),
  );
}

/** Table of the distortion. @param {Calibration} calibration */
export function distortionValues(calibration) {
  const moves = displacements(calibration, TABLE_GRID);
  const middles = [0, 1].map((axis) =>
    Array.from(
      { length: TABLE_GRID[axis] },
      (_, index) => ((index + 0.5) * calibration.img_size[axis]) / TABLE_GRID[axis] - 0.5,
    ),
  );
  const at = (/** @type {number} */ u, /** @type {number} */ v) =>
    moves.find(({ to }) => Math.abs(to[0] - u) < 1e-6 && Math.abs(to[1] - v) < 1e-6);
  const length = (/** @type {ReturnType<typeof at>} */ move) =>
    move ? Math.hypot(move.to[0] - move.from[0], move.to[1] - move.from[1]) : null;
  return valuesTable(
    t("result.distortion_table"),
    middles[0].map(Math.round),
    middles[1].map((v) => ({ v: Math.round(v), values: middles[0].map((u) => length(at(u, v))) })),
  );
}

/** @param {string} caption @param {number[]} columns px @param {{v: number, values: (number | null)[]}[]} rows */
function valuesTable(caption, columns, rows) {
  return el(
    "table",
    { class: "values" },
    el("caption", {}, caption),
    el(
      "thead",
      {},
      el(
        "tr",
        {},
        el("th", { scope: "col" }, "y \\ x, px"),
        ...columns.map((u) => el("th", { scope: "col", class: "number" }, String(u))),
      ),
    ),
    el(
      "tbody",
      {},
      ...rows.map(({ v, values }) =>
        el(
          "tr",
          {},
          el("th", { scope: "row" }, String(v)),
          ...values.map((value) => el("td", {}, value === null ? "–" : rough(value))),
        ),
      ),
    ),
  );
}
