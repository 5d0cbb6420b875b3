// Card of one picture of the series: a thumbnail with its corners, and the outcome.
import { el } from "../lib/dom.js";
import { t } from "../lib/i18n.js";
import { viewOutcome } from "../lib/series.js";
import { isView } from "./group.js";

/** @import { Judgement } from "../lib/series.js" */

/**
 * @typedef {import("./group.js").Found & {thumbnail: HTMLCanvasElement}} Picture
 */

const WIDTH = 240; // px

/** @param {ImageBitmap | VideoFrame} picture @returns {[number, number]} px */
export const sizeOf = (picture) =>
  "displayWidth" in picture ? [picture.displayWidth, picture.displayHeight] : [picture.width, picture.height];

/** A small copy. @param {ImageBitmap | VideoFrame} picture */
export function thumbnail(picture) {
  const [width, height] = sizeOf(picture);
  const canvas = el("canvas", { width: WIDTH, height: Math.round((height * WIDTH) / width), "aria-hidden": "true" });
  const context = canvas.getContext("2d");
  if (!context) return canvas;
  context.imageSmoothingQuality = "high";
  context.drawImage(picture, 0, 0, canvas.width, canvas.height);
  return canvas;
}

/**
 * Marks corners on a small copy.
 * @param {HTMLCanvasElement} canvas @param {number[][]} points px of the photo @param {number} width of the photo, px
 */
export function mark(canvas, points, width) {
  const context = canvas.getContext("2d");
  if (!context) return;
  const scale = canvas.width / width;
  context.fillStyle = "#ffb000";
  context.strokeStyle = "#1c1300";
  for (const [x, y] of points) {
    context.beginPath();
    context.arc((x + 0.5) * scale, (y + 0.5) * scale, 2.4, 0, 7);
    context.fill();
    context.stroke();
  }
}

/**
 * @param {Picture} picture @param {boolean} chosen does it belong to the series that is calibrated?
 * @param {Judgement | undefined} judgement
 */
export function card(picture, chosen, judgement) {
  const { name, thumbnail: small, ids } = picture;
  const what = !isView(picture)
    ? t(ids.length ? "photos.too_few" : "photos.no_board")
    : !chosen
      ? t("photos.other_series")
      : judgement
        ? viewOutcome(judgement)
        : t("photos.corners", { count: ids.length });
  const kind = judgement?.accepted ? "taken" : isView(picture) && chosen ? "" : "unused";
  return el("li", { class: kind }, small, el("p", { class: "name" }, name), el("p", { class: "what number" }, what));
}
