// Limits of the self-service plans, as in `layers/service/calibdb/access/plans.py`.
import { el } from "../lib/dom.js";
import { t } from "../lib/i18n.js";
import { KINDS, formatCount } from "./use-chart.js";

/** @import { HourlyLimits } from "../vendor/api.js" */

/**
 * Calls in one hour: on trial, then on free of each visitor and of all together.
 * @type {Record<string, [number, number, number]>}
 */
export const PLANS = {
  lookups: [600, 600, 10000],
  sessions: [20, 20, 60],
  views: [400, 400, 1500],
  poses: [1200, 1200, 4500],
};

/** Rows of the table that compares the plans. */
export const planRows = () =>
  KINDS.map((kind) =>
    el(
      "tr",
      {},
      el("th", { scope: "row" }, t(`developers.kind_${kind}`)),
      ...PLANS[kind].map((limit) => el("td", {}, formatCount(limit))),
    ),
  );

/** Limits of one token as a table. @param {HourlyLimits} limits */
export function limitsTable({ each, together }) {
  const written = (/** @type {number | null} */ limit) =>
    limit === null ? t("developers.unlimited") : formatCount(limit);
  return el(
    "table",
    {},
    el("caption", {}, t("developers.limits_of_token")),
    el(
      "thead",
      {},
      el(
        "tr",
        {},
        el("th", { scope: "col" }, t("developers.an_hour")),
        el("th", { scope: "col", class: "number" }, t("developers.each")),
        el("th", { scope: "col", class: "number" }, t("developers.together")),
      ),
    ),
    el(
      "tbody",
      {},
      ...KINDS.map((kind) =>
        el(
          "tr",
          {},
          el("th", { scope: "row" }, t(`developers.kind_${kind}`)),
          el("td", {}, written(each[kind])),
          el("td", {}, written(together[kind])),
        ),
      ),
    ),
  );
}
