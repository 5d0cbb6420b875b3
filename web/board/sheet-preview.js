// A printed sheet in small: the board as it lies on the paper.
import { sizeOf } from "../lib/board.js";
import { blackRectangles } from "../lib/board-drawing.js";
import { make } from "../lib/svg.js";

/**
 * @param {import("../lib/board.js").Board} board
 * @param {[number, number]} paper mm, landscape
 * @param {number} side of a square, mm
 * @returns {SVGElement}
 */
export function sheetPreview(board, [width, height], side) {
  const [columns, rows] = sizeOf(board);
  const [left, top] = [(width - columns * side) / 2, (height - rows * side) / 2];
  const path = blackRectangles(board)
    .map(([x, y, w, h]) => `M${left + x * side} ${top + y * side}h${w * side}v${h * side}h${-w * side}z`)
    .join("");
  return make("svg", { viewBox: `0 0 ${width} ${height}`, "aria-hidden": "true" }, [
    make("rect", { class: "sheet-paper", width, height }),
    make("path", { d: path }),
  ]);
}
