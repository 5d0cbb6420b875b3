// Part of a result with its numbers: camera matrix and distortion, to be read and to be copied, the quality, and what
// the lens does.
import { el } from "../dom.js";
import { number, rough, t } from "../i18n.js";
import { copyButton, hint } from "./menu.js";
import { fieldOfView, intrinsics } from "./numbers.js";
import { distortionPlot, profilePlot } from "./plots.js";
import { distortionValues, figure } from "./tiles.js";
import { matrixText, valueText } from "./values.js";

/** @import { Calibration, Report } from "./numbers.js" */

/**
 * @param {Calibration} calibration @param {Pick<Report, "std"> & Partial<Report> | null} report
 * @param {{pending?: boolean}} [options] pending: the standard deviations are on their way, and with them how many
 *   digits count
 */
export function numbersPart(calibration, report, { pending = false } = {}) {
  const { horizontal, vertical, diagonal } = fieldOfView(calibration);
  const degrees = (/** @type {number | null} */ angle) => (angle === null ? "–" : `${number(angle, 1)}°`);
  /** @param {(Node | string)[]} name @param {string} value @param {string} [std] */
  const row = (name, value, std) =>
    el(
      "tr",
      {},
      el("th", { scope: "row" }, ...name),
      el("td", {}, value),
      ...(std === undefined ? [] : [el("td", { class: "std" }, std)]),
    );
  const px = (/** @type {(Node | string)[]} */ name, /** @type {number | null | undefined} */ value) =>
    typeof value === "number" ? [row(name, `${rough(value)}\u00a0px`)] : [];
  const values = intrinsics(calibration, /** @type {Report | null} */ (report));
  return el(
    "div",
    { class: "columns" },
    el(
      "div",
      {},
      el(
        "table",
        { class: `intrinsics ${pending ? "pending" : ""}`, "aria-busy": pending ? "true" : false },
        el("caption", {}, t("result.intrinsics", { model: calibration.distortion_model })),
        el(
          "tbody",
          {},
          ...values.map(({ name, value, std, digits, unit }) => {
            const written = valueText(value, std, digits, unit);
            // Without any standard deviation there is no column for them.
            return row([name], written.value, written.std || (pending || report ? "" : undefined));
          }),
        ),
      ),
    ),
    el(
      "div",
      {},
      el(
        "table",
        {},
        el("caption", {}, t("result.quality")),
        el(
          "tbody",
          {},
          ...px(
            [t("result.uncertainty"), hint(t("result.uncertainty"), t("result.uncertainty_hint"))],
            calibration.uncertainty.rms,
          ),
          ...px([t("result.inside")], calibration.uncertainty.inside),
          ...px([t("result.largest")], calibration.uncertainty.max),
          ...px(
            [t("result.reprojection"), hint(t("result.reprojection"), t("result.reprojection_hint"))],
            calibration.avg_reprojection_error,
          ),
          ...px([t("result.spread")], calibration.spread),
          ...(horizontal === null && vertical === null
            ? []
            : [
                row(
                  [t("result.field")],
                  [horizontal, vertical].map(degrees).join("\u00a0×\u00a0") +
                    (diagonal === null ? "" : ` (${degrees(diagonal)})`),
                ),
              ]),
          // Last, since it arrives with the report: nothing moves below it.
          ...px([t("result.held_out")], report?.held_out ?? calibration.held_out_error),
        ),
      ),
      copies(calibration),
    ),
  );
}

/**
 * Distortion of the lens as a figure and as a table.
 * @param {Calibration} calibration of a model that is known here
 * @param {Report | null} report
 */
export const lensPart = (calibration, report) =>
  el(
    "div",
    { class: "columns" },
    figure(distortionPlot(calibration, report)),
    el("div", { class: "lens" }, figure(profilePlot(calibration, report)), distortionValues(calibration)),
  );

/** @param {Calibration} calibration */
function copies(calibration) {
  const text = (/** @type {"numpy" | "json"} */ form) => {
    const { K, D } = matrixText(calibration, form);
    return form === "numpy" ? `${K}\n${D}` : `{"K": ${K}, "D": ${D}}`;
  };
  return el(
    "div",
    { class: "actions copies" },
    copyButton(t("result.copy_numpy"), () => text("numpy"), { class: "small", id: "copy-numpy" }),
    copyButton(t("result.copy_json"), () => text("json"), { class: "small", id: "copy-json" }),
  );
}
