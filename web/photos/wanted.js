// Drawing of the photograph that would help most, and the way to add it.
import { el } from "../lib/dom.js";
import { t } from "../lib/i18n.js";
import { imagePlot, make, short } from "../lib/svg.js";
import { drawnBoard } from "../lib/pose-drawing.js";

/**
 * @param {import("../lib/board.js").Board} board
 * @param {import("../vendor/api.js").Pose} pose
 * @param {[number, number]} size px
 * @param {{addMore: () => void, isFolded: boolean}} options addMore: called to choose more photographs; isFolded: only
 *   who wants to knows
 */
export function wantedFigure(board, pose, size, { addMore, isFolded }) {
  const { svg, area, x, y } = imagePlot(size, t("photos.like_this"));
  const points = (/** @type {number[][]} */ list) => list.map(([u, v]) => `${short(x(u))},${short(y(v))}`).join(" ");
  const { rim, black } = drawnBoard(board, pose);
  area.append(make("polygon", { points: points(rim), class: "paper" }));
  area.append(make("path", { d: black.map((polygon) => `M${points(polygon)}Z`).join(""), class: "square" }));
  area.append(make("polygon", { points: points(rim), class: "outline" }));
  const add = el("button", { type: "button", class: isFolded ? "" : "primary", id: "add-more" }, t("photos.add_more"));
  add.addEventListener("click", addMore);
  const figure = el("figure", { class: "figure measured" }, svg, el("figcaption", {}, t("photos.like_this")), add);
  return isFolded ? el("details", { class: "which-board" }, el("summary", {}, t("photos.better")), figure) : figure;
}
