// Drawing of the photograph that would help most, and the way to add it.
import { button, el, make } from "../lib/dom.js";
import { t } from "../lib/i18n.js";
import { imagePlot, short } from "../lib/svg.js";
import { corners as allCorners } from "../lib/board.js";
import { blackRectangles } from "../lib/board-drawing.js";
import { apply, homography } from "../lib/homography.js";
import { blackSquares, vertexOf } from "../lib/capture/marks.js";

/**
 * @import { Board } from "../lib/board.js"
 * @import { Polygon } from "../lib/capture/marks.js"
 */

/**
 * @param {Board} board
 * @param {import("../vendor/api.js").Pose} pose
 * @param {[number, number]} size px
 * @param {{addMore: () => void, isFolded: boolean}} options addMore: called to choose more photographs; isFolded: show
 *   the details on request only
 */
export function wantedFigure(board, pose, size, { addMore, isFolded }) {
  const { svg, area, x, y } = imagePlot(size, t("photos.like_this"));
  const points = (/** @type {number[][]} */ list) => list.map(([u, v]) => `${short(x(u))},${short(y(v))}`).join(" ");
  const { rim, black } = drawnBoard(board, pose);
  area.append(make("polygon", { points: points(rim), class: "paper" }));
  area.append(make("path", { d: black.map((polygon) => `M${points(polygon)}Z`).join(""), class: "square" }));
  area.append(make("polygon", { points: points(rim), class: "outline" }));
  const add = button(t("photos.add_more"), addMore, { class: isFolded ? "" : "primary", id: "add-more" });
  const figure = el("figure", { class: "figure measured" }, svg, el("figcaption", {}, t("photos.like_this")), add);
  return isFolded ? el("details", { class: "which-board" }, el("summary", {}, t("photos.better")), figure) : figure;
}

/**
 * Rim and black areas of a board whose corners are those of a pose. If a lens is hardly known, its model bends the
 * board's edge in another way than the corners. So the rim follows the corners, and encloses all of them.
 * @param {Board} board @param {{ids: number[], corners: number[][], outline: number[][]}} pose
 * @returns {{rim: Polygon, black: Polygon[]}} px
 */
export function drawnBoard(board, pose) {
  const [columns, rows] = board.squares;
  const whole = board.kind === "aprilgrid" ? null : completed(board, pose);
  if (!whole) return { rim: pose.outline, black: blackSquares(board, pose) };
  const vertex = vertexOf(board, whole);
  /** A place of the board, squares. @param {number} x @param {number} y */
  const place = (x, y) => {
    const [column, row] = [Math.min(columns - 1, Math.floor(x)), Math.min(rows - 1, Math.floor(y))];
    const corners = [
      [0, 0],
      [1, 0],
      [0, 1],
      [1, 1],
    ].map(([u, v]) => /** @type {number[]} */ (vertex(column + u, row + v)));
    const [u, v] = [x - column, y - row];
    return [0, 1].map(
      (k) =>
        (1 - v) * ((1 - u) * corners[0][k] + u * corners[1][k]) + v * ((1 - u) * corners[2][k] + u * corners[3][k]),
    );
  };
  const black = blackRectangles(board).map(([x, y, width, height]) =>
    [
      [x, y],
      [x + width, y],
      [x + width, y + height],
      [x, y + height],
    ].map(([u, v]) => place(u, v)),
  );
  return { rim: rimOf(board, whole), black };
}

/**
 * The pose with the corners that lie outside the picture.
 * @param {Board} board
 * @param {{ids: number[], corners: number[][]}} pose
 */
function completed(board, { ids, corners }) {
  const places = allCorners(board);
  const h = homography(
    ids.map((id) => places[id]),
    corners,
  );
  const seen = new Map(ids.map((id, index) => [id, corners[index]]));
  return h && { ids: places.map((_, id) => id), corners: places.map((place, id) => seen.get(id) ?? apply(h, place)) };
}

/** @param {Board} board @param {{ids: number[], corners: number[][]}} pose with all corners @returns {Polygon} */
function rimOf(board, pose) {
  const [columns, rows] = board.squares;
  const vertex = vertexOf(board, pose);
  const range = (/** @type {number} */ count) => Array.from({ length: count }, (_, n) => n);
  const rim = [
    ...range(columns).map((x) => vertex(x, 0)),
    ...range(rows).map((y) => vertex(columns, y)),
    ...range(columns).map((x) => vertex(columns - x, rows)),
    ...range(rows).map((y) => vertex(0, rows - y)),
  ];
  return /** @type {Polygon} */ (rim);
}
