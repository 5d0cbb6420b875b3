// Rectified pair of two cameras with epipolar lines: what one camera shows in a row is in the same row of the other.
import { el } from "../lib/dom.js";
import { t } from "../lib/i18n.js";
import { imageInput } from "../lib/files.js";
import { rectifyPair } from "../sdk/rig.js";
import { cameraName } from "./status-text.js";

/** @import { Rig } from "../sdk/rig.js" */

const LINES = 12; // epipolar lines over the pictures

/**
 * @param {Rig} rig @param {Map<number, ImageBitmap>} pictures of the last views, by position
 */
export function rectifiedPart(rig, pictures) {
  const positions = rig.extrinsics.map(({ position }) => position);
  const select = (/** @type {string} */ label, /** @type {number} */ chosen) => {
    const made = el(
      "select",
      { "aria-label": label },
      ...positions.map((position) => new Option(cameraName(position), String(position))),
    );
    made.value = String(chosen);
    return made;
  };
  const [left, right] = [select(t("rig.left"), 0), select(t("rig.right"), 1)];
  const view = el("div", { class: "pair" });
  const status = el("p", { class: "muted", role: "status" });
  /** @type {import("../sdk/pair-rectifier.js").PairRectifier<HTMLCanvasElement> | null} */
  let pair = null;
  const draw = async () => {
    pair?.dispose();
    pair = null;
    const chosen = [Number(left.value), Number(right.value)];
    view.replaceChildren();
    status.textContent = "";
    if (chosen[0] === chosen[1]) return void (status.textContent = t("rig.two_different"));
    const found = chosen.map((position) => pictures.get(position));
    const choosers = chosen.map((position) => {
      const { img_size: size } = rig.calibrations[position];
      const words = t(pictures.has(position) ? "rig.another_picture" : "rig.choose_picture", {
        camera: cameraName(position),
      });
      const input = imageInput({}, size, {
        onImage(picture) {
          pictures.get(position)?.close();
          pictures.set(position, picture);
          void draw();
        },
        onProblem: (code) =>
          (status.textContent = t(code === "shape" ? "rig.wrong_size" : "rig.no_image", { size: size.join(" × ") })),
      });
      return el("label", { class: "button" }, words, input);
    });
    const row = el("div", { class: "actions" }, ...choosers);
    if (found.includes(undefined)) return void view.append(el("p", {}, t("rig.pictures_missing")), row);
    try {
      pair = await /** @type {typeof rectifyPair<HTMLCanvasElement>} */ (rectifyPair)(
        /** @type {ImageBitmap} */ (found[0]),
        /** @type {ImageBitmap} */ (found[1]),
        rig,
        { positions: /** @type {[number, number]} */ (chosen) },
      );
      const { isVertical } = pair.rectification;
      for (const [index, canvas] of [pair.left, pair.right].entries()) {
        canvas.setAttribute("role", "img");
        canvas.setAttribute("aria-label", t("rig.rectified_of", { camera: cameraName(chosen[index]) }));
      }
      view.append(
        el("div", { class: `epipolar${isVertical ? " vertical" : ""}` }, pair.left, pair.right, lines()),
        row,
      );
    } catch (error) {
      console.info("no rectified pair:", String(error)); // no GPU, or cameras that look apart
      view.append(el("p", {}, t("rig.no_pair")), row);
    }
  };
  for (const each of [left, right]) each.addEventListener("change", () => void draw());
  void draw();
  const choice = positions.length > 2 ? [el("div", { class: "fields" }, left, right)] : [];
  return {
    element: el(
      "div",
      { class: "rectified" },
      el("p", { class: "muted" }, t("rig.rectified_text")),
      ...choice,
      view,
      status,
    ),
    dispose: () => pair?.dispose(),
  };
}

/** Lines over both pictures. */
function lines() {
  return el("div", { class: "lines", "aria-hidden": "true" }, ...Array.from({ length: LINES }, () => el("span", {})));
}
