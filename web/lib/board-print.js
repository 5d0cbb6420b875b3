// The board as a file to print, with what the page's language says below it.
import boardWords from "../messages/board.js";
import { PAPERS, boardPdf, squareSide } from "./board-pdf.js";
import { addMessages, number, t } from "./i18n.js";
import { lettering } from "./lettering.js";

/** @typedef {import("./board.js").Board} Board */

addMessages({ board: boardWords });

const MIN_SQUARE_MM = 5; // that printers and cameras still do justice to
/** Regions whose paper is Letter, after CLDR. */
const LETTER_REGIONS = new Set("BZ CA CL CO CR DO GT HN MX NI PA PH PR SV US VE".split(" "));

/** Papers on which the squares are large enough. @param {Board} board @returns {string[]} names */
export function papersFor(board) {
  return Object.keys(PAPERS).filter((paper) => squareSide(board, PAPERS[paper]) >= MIN_SQUARE_MM);
}

/**
 * The paper that a visitor's printer holds, by the region of the browser's language.
 * @param {readonly string[]} preferred BCP 47, best first
 */
export function usualPaper(preferred) {
  const tags = preferred.filter((tag) => /^[a-z]{2,3}\b/i.test(tag));
  const region = tags.length > 0 ? new Intl.Locale(tags[0]).maximize().region : "";
  return LETTER_REGIONS.has(region ?? "") ? "Letter" : "A4";
}

/** Side of a square, mm. @param {Board} board @param {string} paper */
export const squareOn = (board, paper) => squareSide(board, PAPERS[paper]);

/** Name of the file. @param {string} paper */
export const fileName = (paper) => `calibdb-board-${paper.toLowerCase()}.pdf`;

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
