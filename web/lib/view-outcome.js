// The outcome of one view of a series, as a sentence.
import { number, t } from "./i18n.js";

/**
 * True if the view was taken, and what it did to the predicted error.
 * @param {import("./series.js").Judgement} judgement
 */
export function viewOutcome({ accepted, reason, before, after }) {
  const px = (/** @type {number} */ value) => number(value, value < 1 ? 2 : 1);
  if (!accepted) return t(`photos.refused_${reason === "no_information" ? "no_information" : "other"}`);
  if (after === null) return t("photos.taken");
  return before === null
    ? t("photos.first", { after: px(after) })
    : t("photos.added", { before: px(before), after: px(after) });
}
