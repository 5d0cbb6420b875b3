// Part of a result that shows what it does: a picture before and after, and any other photograph of this camera.
import { button, el, liveRegion } from "../dom.js";
import { formatSize, t } from "../i18n.js";
import { imageInput } from "../files.js";
import { comparison, shrinkCalibration } from "./compare.js";
import { gridPicture } from "./grid-picture.js";

/** @import { Calibration } from "./numbers.js" */

/**
 * @param {Calibration} calibration of a model that is known here
 * @param {HTMLCanvasElement | null} picture of this camera; null: a grid, as this lens shows it
 * @param {(picture: HTMLCanvasElement) => void} onPicture called with another that was chosen
 * @param {(() => void) | null} [turnOff] ends the picture of the open camera; null: it does not move
 * @returns {{element: HTMLElement, refresh: () => void, dispose: () => void}}
 */
export function straightPart(calibration, picture, onPicture, turnOff = null) {
  const shown = comparison(calibration, picture ?? gridPicture(shrinkCalibration(calibration)));
  return {
    element: el(
      "div",
      { class: "straight" },
      shown.element,
      el("div", { class: "actions" }, shown.whole, chooser(calibration, onPicture)),
      turnOff
        ? el(
            "p",
            { class: "live" },
            el("span", {}, t("result.live")),
            button(t("result.turn_off"), turnOff, { id: "turn-off", class: "small" }),
          )
        : el("p", { class: "muted" }, t(picture ? "result.trial_text" : "result.grid_text")),
    ),
    refresh: shown.refresh,
    dispose: shown.dispose,
  };
}

/** @param {Calibration} calibration @param {(picture: HTMLCanvasElement) => void} onPicture */
function chooser({ img_size: [width, height] }, onPicture) {
  const problem = el("p", { class: "problem", id: "trial-problem", role: "status" });
  const complain = liveRegion(problem);
  const input = imageInput({ id: "trial-picture" }, [width, height], {
    onStart: () => complain(),
    onImage(image) {
      const canvas = el("canvas", { width, height });
      canvas.getContext("2d")?.drawImage(image, 0, 0, width, height);
      image.close();
      onPicture(canvas);
    },
    onProblem: (code) =>
      complain(() =>
        code === "shape"
          ? t("result.picture_shape", { size: formatSize([width, height]) })
          : t("result.picture_unreadable"),
      ),
  });
  const label = el("label", { class: "button" }, input, el("span", {}, t("result.picture")));
  return el("div", { class: "chooser" }, label, problem);
}
