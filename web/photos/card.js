// One picture of the series: small, with the corners found, and what became of it.
import { el } from "../dom.js";
import { number, t } from "../i18n.js";
import { isView } from "./group.js";

/**
 * @typedef {import("./group.js").Found & {thumbnail: HTMLCanvasElement}} Picture
 * @typedef {import("./series.js").Judgement} Judgement
 */

const WIDTH = 240; // px

/** A small copy with the corners marked. @param {ImageBitmap} picture @param {number[][]} points */
export function thumbnail(picture, points) {
  const scale = WIDTH / picture.width;
  const canvas = el("canvas", { width: WIDTH, height: Math.round(picture.height * scale), "aria-hidden": "true" });
  const context = canvas.getContext("2d");
  if (!context) return canvas;
  context.imageSmoothingQuality = "high";
  context.drawImage(picture, 0, 0, canvas.width, canvas.height);
  context.fillStyle = "#ffb000";
  context.strokeStyle = "#1c1300";
  for (const [x, y] of points) {
    context.beginPath();
    context.arc((x + 0.5) * scale, (y + 0.5) * scale, 2.4, 0, 7);
    context.fill();
    context.stroke();
  }
  return canvas;
}

/**
 * @param {Picture} picture @param {boolean} chosen does it belong to the series that is calibrated?
 * @param {Judgement | undefined} judgement
 */
export function card(picture, chosen, judgement) {
  const { name, thumbnail: small, ids } = picture;
  const what = !isView(picture) ? t(ids.length ? "photos.too_few" : "photos.no_board")
    : !chosen ? t("photos.other_series")
    : judgement ? became(judgement) : t("photos.corners", { count: ids.length });
  const kind = judgement?.accepted ? "taken" : isView(picture) && chosen ? "" : "unused";
  return el("li", { class: kind }, small, el("p", { class: "name" }, name), el("p", { class: "what number" }, what));
}

/** What became of a view. @param {Judgement} judgement */
export function became({ accepted, reason, before, after }) {
  const px = (/** @type {number} */ value) => number(value, value < 1 ? 2 : 1);
  if (!accepted) return t(`photos.refused_${reason === "no_information" ? "no_information" : "other"}`);
  if (after === null) return t("photos.taken");
  return before === null ? t("photos.first", { after: px(after) }) : t("photos.added", { before: px(before), after: px(after) });
}
