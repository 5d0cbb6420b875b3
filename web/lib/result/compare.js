// Comparison of a picture before and after rectification, with a slider between them.
import { el } from "../dom.js";
import { t } from "../i18n.js";
import { Rectifier, RectifierError } from "../../sdk/rectifier.js";

/** @import { Calibration } from "./numbers.js" */

const MAX_WIDTH_PX = 1600; // px; more is not visible here, and maps of large photos would fill the GPU

/**
 * The calibration of the same picture made smaller: lengths scale, pixel centres stay at whole numbers.
 * @param {Calibration} calibration
 * @returns {Calibration}
 */
export function shrinkCalibration(calibration) {
  const {
    img_size: [width, height],
    camera_matrix: [[fx, , cx], [, fy, cy]],
  } = calibration;
  const s = Math.min(1, MAX_WIDTH_PX / width);
  const centre = (/** @type {number} */ c) => (c + 0.5) * s - 0.5;
  return {
    ...calibration,
    img_size: [Math.round(width * s), Math.round(height * s)],
    camera_matrix: [
      [fx * s, 0, centre(cx)],
      [0, fy * s, centre(cy)],
      [0, 0, 1],
    ],
  };
}

/**
 * @param {Calibration} whole
 * @param {HTMLCanvasElement} picture of the calibration's size; it stays on this device
 * @returns {{element: HTMLElement, whole: HTMLElement | null, refresh: () => void, dispose: () => void}} whole: choice
 *   of the whole picture; refresh: shows what the picture has become
 */
export function comparison(whole, picture) {
  const calibration = shrinkCalibration(whole);
  const [width, height] = calibration.img_size;
  const before = el("canvas", { width, height, role: "img", "aria-label": t("result.before") });
  const context = before.getContext("2d");
  context?.drawImage(picture, 0, 0, width, height);
  let rectifier;
  try {
    rectifier = new Rectifier(calibration);
  } catch (error) {
    if (!(error instanceof RectifierError)) throw error;
    return { element: el("p", { class: "muted" }, t("result.no_webgl")), whole: null, refresh() {}, dispose() {} };
  }
  const made = rectifier;
  const after = made.canvas;
  after.setAttribute("role", "img");
  after.setAttribute("aria-label", t("result.after"));
  made.draw(before);
  after.addEventListener("webglcontextrestored", () => made.draw(before));

  const slider = el("input", { type: "range", min: 0, max: 100, value: 50, "aria-label": t("result.slider") });
  const stage = el(
    "div",
    { class: "compare" },
    before,
    after,
    slider,
    el("span", { class: "side", "aria-hidden": "true" }, t("result.before")),
    el("span", { class: "side", "aria-hidden": "true" }, t("result.after")),
  );
  const cut = () => stage.style.setProperty("--cut", String(slider.valueAsNumber / 100));
  slider.addEventListener("input", cut);
  cut();
  const all = el("input", { type: "checkbox" });
  all.addEventListener("change", () => {
    made.balance(all.checked ? 1 : 0);
    made.draw(before);
  });
  const edges = el("label", { class: "choice" }, all, el("span", {}, t("result.keep_edges")));
  const refresh = () => {
    context?.drawImage(picture, 0, 0, width, height);
    made.draw(before);
  };
  return { element: stage, whole: edges, refresh, dispose: () => made.dispose() };
}
