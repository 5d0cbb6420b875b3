// Download of a calibration in any format, with the error of the conversion.
import { ApiError } from "../api.js";
import { el } from "../dom.js";
import { number, t } from "../i18n.js";
import { keepItem, readItem } from "../storage.js";
import { jsonText } from "./values.js";
import { FORMATS } from "../../vendor/formats.js";
import { save } from "./source.js";

/**
 * @import { Calibration } from "./numbers.js"
 * @import { Saved } from "./source.js"
 */

const VISIBLE_ERROR_PX = 0.1; // px; a smaller error is not visible in any picture, and is not mentioned
const FULL_COVERAGE = 0.995; // share of the picture
const EXACT_ERROR_PX = 1e-3; // px; a file may be written with fewer digits
const FORMAT_KEY = "calibdb.format"; // where the last one is kept
const CORNERS = new Set(["corners-vnl"]); // what was measured, and no lens

/**
 * @param {{calibration: Calibration, explain: (error: unknown) => string, of?: {id: string | null, without?:
 *   number[]}}} result of: where it is stored, and which of its views are left out
 * @param {string} [suffix] of the ids, where a page offers several
 * @param {{primary?: boolean, before?: Node[], after?: Node[]}} [around] buttons in the same row
 */
export function downloadPart(
  { calibration, explain, of = calibration },
  suffix = "",
  { primary = true, before = [], after = [] } = {},
) {
  const [id, about] = [`format${suffix}`, `format-about${suffix}`];
  const select = el(
    "select",
    { id, "aria-label": t("result.format"), "aria-describedby": about },
    ...FORMATS.map((format) => new Option(t(`formats.name_${format}`), format)),
  );
  const last = readItem(FORMAT_KEY) ?? "";
  if (FORMATS.includes(last)) select.value = last;
  const purpose = el("p", { id: about, class: "muted" }, t(`formats.for_${select.value}`));
  const status = el("p", { role: "status", class: "saved" });
  const button = el(
    "button",
    { type: "button", id: `download${suffix}`, class: primary ? "primary" : "" },
    t("result.download"),
  );
  select.addEventListener("change", () => {
    purpose.textContent = t(`formats.for_${select.value}`);
    keepItem(FORMAT_KEY, select.value);
    say("", false);
  });
  /** @param {string} text @param {boolean} bad */
  const say = (text, bad) => {
    status.classList.toggle("problem", bad);
    status.textContent = text;
  };
  button.addEventListener("click", async () => {
    button.disabled = true;
    say(t("formats.writing"), false);
    try {
      const saved = await save(calibration, select.value, of);
      say(CORNERS.has(select.value) ? t("formats.saved", { name: saved.name }) : conversionText(saved), false);
    } catch (error) {
      // 422: no camera of the format approximates this one, or the format needs data that this calibration lacks.
      const impossible = error instanceof ApiError && error.status === 422;
      say(impossible ? reason(select.value, error) : explain(error), true);
    } finally {
      button.disabled = false;
    }
  });
  return el(
    "div",
    { class: "take" },
    el("div", { class: "actions" }, ...before, el("span", { class: "joined" }, button, select), ...after),
    purpose,
    status,
  );
}

/** The whole record, as the API answers it. @param {Calibration} calibration @param {string} [suffix] of the id */
export function recordPart(calibration, suffix = "") {
  return el(
    "pre",
    { tabindex: 0, "aria-label": t("result.as_json") },
    el("code", { id: `json${suffix}` }, `${jsonText(calibration)}\n`),
  );
}

/**
 * Reason why there is no such file; of the service's own words, which are English, only the number.
 * @param {string} format
 * @param {ApiError} error
 */
function reason(format, { message }) {
  if (CORNERS.has(format)) return t("formats.impossible_corners");
  const [, far] = /([\d.]+) px/.exec(message) ?? [];
  return far ? t("formats.impossible_far", { error: number(Number(far), 0) }) : t("formats.impossible_lens");
}

/** Remarks in the file, besides the calibration. @param {Saved} saved */
export function conversionText({ name, error, coverage }) {
  const parts =
    error > VISIBLE_ERROR_PX
      ? [t("formats.near", { name, error: number(error, error < 1 ? 2 : error < 100 ? 1 : 0) })]
      : [t(error < EXACT_ERROR_PX ? "formats.exact" : "formats.close", { name })];
  if (coverage < FULL_COVERAGE) parts.push(t("formats.partly", { share: Math.floor(100 * coverage) }));
  return parts.join(" ");
}
