// Papers that boards are printed on: their sizes, and which of them a visitor has.
import { sizeOf } from "./board.js";

/** @import { Board } from "./board.js" */

/** Landscape paper, mm. @type {Record<string, [number, number]>} */
export const PAPERS = { A4: [297, 210], A3: [420, 297], Letter: [279.4, 215.9] };

export const MARGIN_MM = 12; // mm; what home printers leave free, and the white edge the outer squares need
export const FOOT = 14; // mm below the board for the scale bar and the text
const MIN_SQUARE_MM = 5; // that printers and cameras still do justice to
/** Regions whose paper is Letter, after CLDR. */
const LETTER_REGIONS = new Set("BZ CA CL CO CR DO GT HN MX NI PA PH PR SV US VE".split(" "));

/**
 * Side of a square, or of a tag, in whole millimetres, the largest that fits.
 * @param {Board} board @param {[number, number]} paper mm
 */
export function squareSide(board, [width, height]) {
  const [columns, rows] = sizeOf(board);
  return Math.floor(Math.min((width - 2 * MARGIN_MM) / columns, (height - 2 * MARGIN_MM - FOOT) / rows));
}

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
