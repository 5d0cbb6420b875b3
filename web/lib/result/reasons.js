// Reasons of a verdict as people read them, and what to do about the probable cause of systematic errors.
import { hasMessage, language, t } from "../i18n.js";

/** @import { Report } from "./numbers.js" */

/**
 * @typedef {{code: string, text: string}} Reason
 */

/** Models for lenses that another cannot follow. */
const WIDE_MODELS = ["fisheye", "rational", "omnidirectional"];

/**
 * Sentences: why a calibration is not good, the probable cause, and notes of the capture; each once.
 * @param {Pick<Report, "verdict" | "systematic"> | null} report
 * @param {Reason[]} notes
 * @param {{distortion_model: string, platform: string}} calibration
 * @returns {string[]}
 */
export function reasonTexts(report, notes, { distortion_model: model, platform }) {
  const { cause, text, model: better } = report?.systematic ?? {};
  const reasons = [...(report?.verdict.reasons ?? []), ...(cause ? [{ code: cause, text: text ?? "" }] : []), ...notes];
  return [...new Map(reasons.map((reason) => [reason.code, reason])).values()].map((reason) =>
    wording(reason, better ?? null, model, platform),
  );
}

/**
 * @param {Reason} reason
 * @param {string | null} better model that follows the lens, if one is known
 * @param {string} model
 * @param {string} platform
 */
function wording({ code, text }, better, model, platform) {
  // With photos, advice on how to hold the board comes too late.
  if (platform === "photographs" && hasMessage(`result.reason_${code}_photos`))
    return t(`result.reason_${code}_photos`);
  if (code === "model_too_simple" && better) return t("result.reason_choose_model", { model: better });
  const models = new Intl.ListFormat(language(), { type: "disjunction" }).format(
    WIDE_MODELS.filter((name) => name !== model),
  );
  return hasMessage(`result.reason_${code}`) ? t(`result.reason_${code}`, { models }) : text;
}
