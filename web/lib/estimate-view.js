// Estimate of a camera that has no calibration yet, clearly marked as an estimate.
import { el } from "./dom.js";
import { number, t } from "./i18n.js";

/** @import { EstimateData } from "../sdk/calibration.js" */

/** @param {EstimateData} estimate */
export function estimateView({ hfov_deg, interval_90, basis, sources }) {
  const [low, high] = interval_90.hfov_deg;
  const facts = [
    [t("estimate.view"), t("estimate.view_value", { value: number(hfov_deg, 0) })],
    [t("estimate.interval"), t("estimate.interval_value", { low: number(low, 0), high: number(high, 0) })],
    [t("estimate.basis"), t(`estimate.basis_${basis}`)],
  ];
  return el(
    "div",
    { class: "estimate" },
    el("p", {}, el("strong", {}, t("estimate.heading"))),
    el("p", { class: "muted" }, t("estimate.text")),
    el(
      "dl",
      {},
      ...facts.map(([term, value]) => el("div", {}, el("dt", {}, term), el("dd", { class: "number" }, value))),
    ),
    sources.length > 0 &&
      el(
        "details",
        {},
        el("summary", {}, t("estimate.sources")),
        el(
          "ul",
          {},
          ...sources.map(({ title, url }) => el("li", {}, el("a", { href: safe(url), rel: "noreferrer" }, title))),
        ),
      ),
  );
}

/** Address of a page; nothing else becomes a link. @param {string} url */
const safe = (url) => (/^https?:\/\//.test(url) ? url : "#");
