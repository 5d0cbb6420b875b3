// List of a result's views, with advice which to retake, and a trial fit without some.
import { button, el } from "../dom.js";
import { language, number, rough, t } from "../i18n.js";
import { viewIssue } from "./numbers.js";
import { magnification, residualPlot } from "./plots.js";

/** @import { Calibration, Report, Result } from "./numbers.js" */

/**
 * @typedef {{without: number[], calibration: Calibration, report: Report | null}} Trial what it is without some views,
 *   by their indices
 *
 * @typedef {object} Choices what a person can do with the views; null where nothing is to be fitted again
 * @property {(without: number[]) => void} choose indices of the views to leave out from now on
 * @property {((without: number[]) => void) | undefined} goOn with the views that are left
 * @property {string} elsewhere address where this camera is calibrated again
 */

/** "5 and 6", counted as people do. @param {number[]} indices */
export const listViews = (indices) =>
  new Intl.ListFormat(language(), { type: "conjunction" }).format(
    [...indices].sort((a, b) => a - b).map((index) => String(index + 1)),
  );

/** Views that are worth taking again. @param {Report} report @returns {number[]} indices */
const viewsToRetake = ({ views }) =>
  views.filter((view) => ["left_out", "stands_out"].includes(viewIssue(view, views) ?? "")).map(({ index }) => index);

/**
 * Views in one row that scrolls sideways, the worst first.
 * @param {Pick<Result, "calibration" | "names" | "photo"> & {report: Report}} result
 * @param {Trial | null} trial what it is without some views
 * @param {Choices | null} choices
 */
export function viewsPart({ calibration, report, names = () => "", photo = () => null }, trial, choices) {
  const factor = magnification(calibration, report);
  const left = trial?.without ?? [];
  const bad = viewsToRetake(report).filter((index) => !left.includes(index));
  const worst = Math.max(...report.views.map(({ rms }) => rms));
  return el(
    "div",
    {},
    el("p", { class: "muted" }, t("result.views_text")),
    bad.length > 0 && advice(bad, left, choices),
    el(
      "ol",
      { class: "views", tabindex: 0, "aria-label": t("result.part_views") },
      ...[...report.views]
        .sort((a, b) => b.rms - a.rms)
        .map((original) => {
          const { index } = original;
          const out = left.includes(index);
          // Of a view that is left out the other fit knows nothing.
          const shown = out ? report : (trial?.report ?? report);
          const view = shown.views.find((each) => each.index === index) ?? original;
          const what = out ? null : viewIssue(view, shown.views);
          const bar = el("span", { class: "bar", "aria-hidden": "true" });
          bar.style.setProperty("--part", String(view.rms / worst));
          return el(
            "li",
            { class: out ? "out" : "", "data-view": index },
            bar,
            residualPlot(calibration, view, shown.views, factor, photo(index)),
            el(
              "div",
              { class: "which" },
              el(
                "p",
                { class: "number" },
                el("strong", {}, t("result.view", { index: index + 1 })),
                ` ${number(view.rms, 2)}\u00a0px`,
                names(index) && el("span", { class: "source muted" }, names(index)),
              ),
              choices && toggle(index, left, choices),
            ),
            what && el("p", { class: "problem" }, t(`result.view_${what}`, { count: view.cut.length })),
          );
        }),
    ),
    choices && trialStatus(calibration, trial, choices),
  );
}

/** @param {number[]} bad @param {number[]} left @param {Choices | null} choices */
function advice(bad, left, choices) {
  const words = el("p", {}, t("result.worth", { count: bad.length, views: listViews(bad) }));
  return choices
    ? el(
        "div",
        { class: "advice" },
        words,
        button(t("result.leave_these", { count: bad.length }), () => choices.choose([...left, ...bad]), {
          id: "leave-these",
        }),
      )
    : words;
}

/** @param {number} index @param {number[]} left @param {Choices} choices */
function toggle(index, left, choices) {
  const out = left.includes(index);
  const next = out ? left.filter((each) => each !== index) : [...left, index];
  return button(t(out ? "result.take_back" : "result.leave_out"), () => choices.choose(next), {
    id: `view-${index}-out`,
    class: "small",
    "aria-label": `${t(out ? "result.take_back" : "result.leave_out")}: ${t("result.view", { index: index + 1 })}`,
  });
}

/**
 * Effect of the choices, and the next step.
 * @param {Calibration} calibration
 * @param {Trial | null} trial
 * @param {Choices} choices
 */
function trialStatus(calibration, trial, choices) {
  const status = el("p", { id: "without-status", role: "status" });
  if (!trial) return el("div", { class: "without" }, status);
  const { without, calibration: less } = trial;
  const values = { count: without.length, views: listViews(without) };
  status.textContent = t("result.without_now", {
    ...values,
    before: rough(calibration.uncertainty.rms),
    after: rough(less.uncertainty.rms),
    fx: number(less.camera_matrix[0][0], 2),
    was: number(calibration.camera_matrix[0][0], 2),
  });
  const { goOn } = choices;
  return el(
    "div",
    { class: "without some" },
    status,
    el(
      "div",
      { class: "actions" },
      goOn
        ? button(t("result.go_on_without", values), () => goOn(without), { class: "primary", id: "go-on-without" })
        : el("a", { class: "button", href: choices.elsewhere }, t("result.calibrate_again")),
      button(t("result.all_again"), () => choices.choose([]), { id: "all-again" }),
    ),
    goOn && el("p", { class: "muted" }, t("result.go_on_text")),
  );
}
