// Comparison of two calibrations of one camera: how far apart they show the world, and their parameters side by side.
import { el } from "../dom.js";
import { dateText, number, rough, t } from "../i18n.js";
import { lensDifference } from "../lens-difference.js";
import { isKnownModel } from "../../sdk/projection.js";
import { figure } from "./tiles.js";
import { intrinsics } from "./numbers.js";
import { heatPlot } from "./plots.js";
import { valueText } from "./values.js";

/** @typedef {Awaited<ReturnType<typeof import("./source.js").load>>} Loaded */

/**
 * @param {Loaded} first
 * @param {Loaded} second of the same size
 * @param {string | null} [name] of the second, instead of its date
 * @returns {HTMLElement}
 */
export function comparisonView(first, second, name = null) {
  const [one, other] = [first.calibration, second.calibration];
  const known = isKnownModel(one.distortion_model) && isKnownModel(other.distortion_model);
  return el("div", { class: "columns" }, known && difference(one, other), parameters(first, second, name));
}

/** @param {Loaded["calibration"]} one @param {Loaded["calibration"]} other */
function difference(one, other) {
  const { px, rms, max } = lensDifference(one, other);
  const found = { rms: rough(rms), max: rough(max) };
  const made = heatPlot(one.img_size, px, max, t("cameras.difference_label", found));
  // A file may say nothing of its error.
  const bars = [one, other].map(({ uncertainty }) => uncertainty?.rms ?? NaN);
  const expected = Math.hypot(...bars);
  const caption = Number.isNaN(expected)
    ? t("cameras.difference_alone", found)
    : t("cameras.difference_caption", { ...found, expected: rough(expected) });
  return figure({ ...made, caption });
}

/** @param {Loaded} one @param {Loaded} other @param {string | null} name */
function parameters(one, other, name) {
  const rows = [intrinsics(one.calibration, one.report), intrinsics(other.calibration, other.report)];
  const dates = [dateText(one.calibration.calibration_time), name ?? dateText(other.calibration.calibration_time)];
  const same = one.calibration.distortion_model === other.calibration.distortion_model;
  const count = same ? rows[0].length : 4; // coefficients of two models say different things
  return el(
    "table",
    { class: "values" },
    el("caption", {}, t("cameras.side_by_side")),
    el(
      "thead",
      {},
      el(
        "tr",
        {},
        el("td", {}),
        ...dates.map((date) => el("th", { scope: "col", class: "number" }, date)),
        el("th", { scope: "col", class: "number" }, t("cameras.apart")),
      ),
    ),
    el(
      "tbody",
      {},
      ...rows[0].slice(0, count).map((a, index) => {
        const b = rows[1][index];
        const digits = Math.max(a.digits, b.digits);
        const texts = [a, b].map((each) => valueText(each.value, each.std, digits, each.unit));
        const sigma = a.std && b.std ? Math.abs(a.value - b.value) / Math.hypot(a.std, b.std) : null;
        return el(
          "tr",
          {},
          el("th", { scope: "row" }, a.name),
          ...texts.map(({ value, std }) =>
            el("td", {}, value, ...(std ? [el("br"), el("span", { class: "muted" }, std)] : [])),
          ),
          el("td", {}, sigma === null ? "–" : `${number(sigma, 1)}\u00a0σ`),
        );
      }),
    ),
  );
}
