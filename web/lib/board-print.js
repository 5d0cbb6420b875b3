// The board as a file to print, with what the page's language says below it.
import { boardPdf } from "./board-pdf.js";
import { DEFAULT_TAG_SPACING, kindOf } from "./board.js";
import { number, t } from "./i18n.js";
import { lettering } from "./lettering.js";
import { PAPERS, squareOn } from "./papers.js";

/** @typedef {import("./board.js").Board} Board */

/** @param {Board} board @param {string} paper @returns {Blob} a PDF */
export function boardFile(board, paper) {
  const {
    squares: [columns, rows],
    marker_ratio,
    dictionary,
    legacy,
    tag_spacing: spacing = DEFAULT_TAG_SPACING,
  } = board;
  const side = squareOn(board, paper);
  const gap = number(side * spacing, 2);
  const marker = number(side * marker_ratio, 2);
  const layout = t(legacy ? "board.layout_legacy" : "board.layout_new");
  const lines = [
    t(`board.pdf_${kindOf(board)}`, { columns, rows, side, marker, dictionary, layout, gap }),
    t("board.pdf_flat"),
  ];
  const content = boardPdf(board, PAPERS[paper], { bar: t("board.pdf_bar"), lines }, lettering);
  return new Blob([content], { type: "application/pdf" });
}
