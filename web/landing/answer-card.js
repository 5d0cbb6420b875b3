// Answer to a lookup of the visitor's own camera, as a card: what is known and what to do with it.
import { el } from "../lib/dom.js";
import { number, pageUrl, rough, formatSize, t } from "../lib/i18n.js";
import { estimateView } from "../lib/estimate-view.js";
import { fieldOfView } from "../lib/result/numbers.js";

/**
 * @typedef {import("../sdk/calibdb.js").CalibrationData} Calibration
 * @typedef {import("../lib/result/numbers.js").Calibration} Known
 */

/** @param {string} name of the camera @param {Calibration & {id?: string | null}} calibration */
export function knownCard(name, calibration) {
  const {
    camera_matrix: [[fx]],
    img_size,
    uncertainty,
    calibrations,
    id,
  } = calibration;
  const { horizontal } = fieldOfView(/** @type {Known} */ (calibration));
  const facts = [
    [t("landing.card_size"), formatSize(img_size)],
    [t("landing.card_focal"), `${number(fx, 1)}\u00a0px`],
    ...(horizontal === null ? [] : [[t("landing.card_view"), `${number(horizontal, 1)}°`]]),
    [t("landing.card_error"), `${rough(uncertainty.rms)}\u00a0px`],
    [t("landing.card_calibrations"), String(calibrations)],
  ];
  return el(
    "div",
    { class: "answer" },
    el("h3", { class: "verdict good" }, t("landing.known_yes", { camera: name })),
    el(
      "dl",
      {},
      ...facts.map(([term, value]) => el("div", {}, el("dt", {}, term), el("dd", { class: "number" }, value))),
    ),
    el(
      "div",
      { class: "actions" },
      id &&
        el(
          "a",
          { class: "button primary", href: pageUrl(`result/?${new URLSearchParams({ id })}`).href },
          t("landing.card_open"),
        ),
      el("a", { class: "button", href: pageUrl("ar/").href }, t("landing.card_ar")),
    ),
  );
}

/**
 * @param {string} name @param {string} address where it is calibrated
 * @param {import("../sdk/calibration.js").EstimateData | null} estimate
 */
export function unknownCard(name, address, estimate) {
  return el(
    "div",
    { class: "answer" },
    el("h3", {}, t("landing.not_yet", { camera: name })),
    el("p", {}, t("landing.not_yet_text")),
    el("div", { class: "actions" }, el("a", { class: "button primary", href: address }, t("landing.calibrate_it"))),
    estimate && estimateView(estimate),
  );
}
