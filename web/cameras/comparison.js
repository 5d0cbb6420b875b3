// Comparison of two calibrations of one camera: how far apart they show the world, and their parameters side by side.
import { el } from "../lib/dom.js";
import { language, number, rough, t } from "../lib/i18n.js";
import { lensDifference } from "../lib/lens-difference.js";
import { isKnownModel } from "../sdk/projection.js";
import { figure } from "../lib/result/tiles.js";
import { intrinsics } from "../lib/result/numbers.js";
import { heatPlot } from "../lib/result/plots.js";
import { load } from "../lib/result/source.js";
import { valueText } from "../lib/result/values.js";

/** @typedef {Awaited<ReturnType<typeof load>>} Loaded */

/** @param {string} first @param {string} second ids @returns {Promise<HTMLElement>} rejects as `load` does */
export async function comparisonView(first, second) {
  const pair = await Promise.all([load(first), load(second)]);
  const [{ calibration: one }, { calibration: other }] = pair;
  const known = isKnownModel(one.distortion_model) && isKnownModel(other.distortion_model);
  return el("div", { class: "columns" }, ...(known ? [difference(one, other)] : []), parameters(pair[0], pair[1]));
}

/** @param {Loaded["calibration"]} one @param {Loaded["calibration"]} other */
function difference(one, other) {
  const { px, rms, max } = lensDifference(one, other);
  const found = { rms: rough(rms), max: rough(max) };
  const made = heatPlot(one.img_size, px, max, t("cameras.difference_label", found));
  const expected = rough(Math.hypot(one.uncertainty.rms, other.uncertainty.rms));
  return figure({ ...made, caption: t("cameras.difference_caption", { ...found, expected }) });
}

/** @param {Loaded} one @param {Loaded} other */
function parameters(one, other) {
  const rows = [intrinsics(one.calibration, one.report), intrinsics(other.calibration, other.report)];
  const dates = [one, other].map(({ calibration }) => new Intl.DateTimeFormat(language(), { dateStyle: "medium" }).format(new Date(calibration.calibration_time * 1000)));
  const same = one.calibration.distortion_model === other.calibration.distortion_model;
  const count = same ? rows[0].length : 4; // coefficients of two models say different things
  return el("table", { class: "values" }, el("caption", {}, t("cameras.side_by_side")),
    el("thead", {}, el("tr", {}, el("td", {}), ...dates.map((date) => el("th", { scope: "col", class: "number" }, date)), el("th", { scope: "col", class: "number" }, t("cameras.apart")))),
    el("tbody", {}, ...rows[0].slice(0, count).map((a, index) => {
      const b = rows[1][index];
      const digits = Math.max(a.digits, b.digits);
      const texts = [a, b].map((each) => valueText(each.value, each.std, digits, each.unit));
      const sigma = a.std && b.std ? Math.abs(a.value - b.value) / Math.hypot(a.std, b.std) : null;
      return el("tr", {}, el("th", { scope: "row" }, a.name),
        ...texts.map(({ value, std }) => el("td", {}, value, ...(std ? [el("br"), el("span", { class: "muted" }, std)] : []))),
        el("td", {}, sigma === null ? "–" : `${number(sigma, 1)}\u00a0σ`));
    })));
}
