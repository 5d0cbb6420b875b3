// The board as a file to print, with what the page's language says below it.
import { boardPdf } from "./board-pdf.js";
import { DEFAULT_TAG_SPACING, kindOf } from "./board.js";
import { number, t } from "./i18n.js";
import { PAPERS, squareOn } from "./papers.js";

/**
 * @import { Lettering } from "./board-pdf.js"
 * @import { Board } from "./board.js"
 */

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

const SIZE = 64; // px; 576 a inch for letters of 8 points
const FONT = `${SIZE}px Helvetica, Arial, "Liberation Sans", sans-serif`;

/**
 * A text as a picture, for files whose fonts have no letters for it.
 * @param {string} text @returns {Lettering | null} null: this browser draws nothing
 */
function lettering(text) {
  const canvas = document.createElement("canvas");
  const before = canvas.getContext("2d");
  if (!before) return null;
  before.font = FONT;
  const bytes = Math.ceil(before.measureText(text).width / 8);
  [canvas.width, canvas.height] = [8 * bytes, Math.ceil(1.4 * SIZE)];
  const depth = Math.round(0.35 * SIZE);
  const context = canvas.getContext("2d", { willReadFrequently: true });
  if (!context) return null;
  context.font = FONT; // another size of the canvas forgets it
  context.fillText(text, 0, canvas.height - depth);
  const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
  const bits = new Uint8Array(bytes * canvas.height).fill(255);
  for (let pixel = 0; pixel < canvas.width * canvas.height; pixel++) {
    if (data[4 * pixel + 3] > 127) bits[pixel >> 3] &= ~(128 >> (pixel & 7));
  }
  return { width: canvas.width, height: canvas.height, size: SIZE, depth, bits };
}
