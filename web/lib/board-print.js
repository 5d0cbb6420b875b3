// The board as a file to print, with what the page's language says below it.
import boardWords from "../messages/board.js";
import { boardPdf } from "./board-pdf.js";
import { addMessages, number, t } from "./i18n.js";
import { lettering } from "./lettering.js";
import { PAPERS, squareOn } from "./papers.js";

/** @typedef {import("./board.js").Board} Board */

addMessages({ board: boardWords });

/** @param {Board} board @param {string} paper @returns {Blob} a PDF */
export function boardFile(board, paper) {
  const { squares: [columns, rows], marker_ratio, dictionary, legacy } = board;
  const side = squareOn(board, paper);
  const marker = number(side * marker_ratio, 2);
  const layout = t(legacy ? "board.layout_legacy" : "board.layout_new");
  const lines = [t("board.pdf_board", { columns, rows, side, marker, dictionary, layout }), t("board.pdf_flat")];
  const content = boardPdf(board, PAPERS[paper], { bar: t("board.pdf_bar"), lines }, lettering);
  return new Blob([content], { type: "application/pdf" });
}
