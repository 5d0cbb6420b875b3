// Display of a file: its views as small plots, or, where it has none, its camera.
import { el, make } from "../lib/dom.js";
import { number, t } from "../lib/i18n.js";
import { imagePlot, short } from "../lib/svg.js";
import { viewOutcome } from "../lib/series.js";
import { MIN_VIEW_CORNERS } from "./read.js";

/**
 * @import { Judgement } from "../lib/series.js"
 * @import { Guess, Numbered } from "./read.js"
 */

const DOT = 5; // plot units

/** @param {Numbered} view @param {[number, number]} size px @param {Judgement | undefined} judgement */
export function card({ name, points }, size, judgement) {
  const usable = points.length >= MIN_VIEW_CORNERS;
  const { svg, area, x, y } = imagePlot(size, t("import.view_label", { name, count: points.length }));
  area.append(...points.map(([u, v]) => make("circle", { cx: short(x(u)), cy: short(y(v)), r: DOT, class: "seen" })));
  const what = judgement
    ? viewOutcome(judgement)
    : usable
      ? t("photos.corners", { count: points.length })
      : t("photos.too_few");
  return el(
    "li",
    { class: judgement?.accepted ? "taken" : usable ? "" : "unused" },
    svg,
    el("p", { class: "name" }, name),
    el("p", { class: "what number" }, what),
  );
}

/**
 * A file without corners: what it is.
 * @param {Guess} guess
 * @param {string | null} own id of the calibration, if it is a file of this service
 * @returns {HTMLElement[]}
 */
export function guessView({ matrix, packed }, own) {
  return [
    el("h2", { id: "guess-title" }, t(packed ? "import.packed" : "import.guess")),
    el("p", {}, t(packed ? "import.packed_text" : "import.guess_text")),
    ...(own
      ? [el("p", {}, el("a", { href: `../result/?${new URLSearchParams({ id: own })}` }, t("import.own_page")))]
      : []),
    el("p", {}, el("a", { href: "../photos/" }, t("import.photos_instead"))),
    ...(matrix
      ? [
          el(
            "table",
            { id: "matrix" },
            el("caption", {}, t("import.matrix")),
            el(
              "tbody",
              {},
              ...matrix.map((row) =>
                el("tr", {}, ...row.map((value) => el("td", {}, number(value, Number.isInteger(value) ? 0 : 3)))),
              ),
            ),
          ),
        ]
      : []),
  ];
}
