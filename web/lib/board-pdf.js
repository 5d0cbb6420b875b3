// The board as a one-page PDF, vector, at true scale. PDF 1.4 after ISO 32000-1: objects, a content stream, xref.
import { sizeOf } from "./board.js";
import { blackRectangles } from "./board-drawing.js";
import { FOOT, MARGIN_MM, squareSide } from "./papers.js";

/** @import { Board } from "./board.js" */

const POINTS_PER_MM = 72 / 25.4;

const LETTERS = 8; // points
const INVERTED_EDGE_MM = 5; // of black around a board that is white on black

/**
 * @typedef {object} Foot text below the board, in the language of the page
 * @property {string} bar next to the scale bar of 100 mm
 * @property {string[]} lines
 *
 * @typedef {object} Lettering a text as a picture
 * @property {number} width px
 * @property {number} height px
 * @property {number} size of the letters, px
 * @property {number} depth of the picture below their line, px
 * @property {Uint8Array} bits row by row, each of whole bytes; 1 is paper
 */

/**
 * @param {Board} board
 * @param {[number, number]} paper mm
 * @param {Foot} foot
 * @param {(text: string) => Lettering | null} letter pictures of texts that the font of every viewer has no letters for
 * @returns {Uint8Array<ArrayBuffer>} the file
 */
export function boardPdf(board, paper, foot, letter) {
  const [width, height] = paper;
  const side = squareSide(board, paper);
  if (side < 1) throw new RangeError("the board has too many squares for this paper");
  const [columns, rows] = sizeOf(board);
  const left = (width - columns * side) / 2;
  const top = (height - FOOT - rows * side) / 2;
  /** mm from the top left of the page to PDF's points from the bottom left @param {number[]} rectangle */
  const path = ([x, y, w, h]) =>
    `${[x, height - y - h, w, h].map((value) => number(value * POINTS_PER_MM)).join(" ")} re`;
  /** @type {Lettering[]} */
  const pictures = [];
  /** @param {number} x @param {number} y @param {string} words */
  const text = (x, y, words) => {
    const [u, v] = [x * POINTS_PER_MM, (height - y) * POINTS_PER_MM];
    const picture = LATIN.test(words) ? null : letter(words);
    if (!picture) return `BT /F1 ${LETTERS} Tf ${number(u)} ${number(v)} Td (${escape(words)}) Tj ET`;
    const scale = LETTERS / picture.size;
    const place = [picture.width * scale, 0, 0, picture.height * scale, u, v - picture.depth * scale]
      .map(number)
      .join(" ");
    return `q ${place} cm /I${pictures.push(picture) - 1} Do Q`;
  };

  const below = top + rows * side + MARGIN_MM / 2;
  const content = [
    "0 g",
    ...(board.inverted ? edge(left, top, columns * side, rows * side).map(path) : []),
    // One path, one fill: viewers that smooth edges leave no hairlines between touching rectangles.
    ...blackRectangles(board).map(([x, y, w, h]) => path([left + x * side, top + y * side, w * side, h * side])),
    "f",
    path([left, below, 100, 0.4]),
    path([left, below - 1, 0.4, 2.4]),
    path([left + 99.6, below - 1, 0.4, 2.4]),
    "f",
    text(left + 103, below + 1, foot.bar),
    ...foot.lines.map((line, index) => text(MARGIN_MM, below + 6 + 4 * index, line)),
  ].join("\n");

  const box = [0, 0, width * POINTS_PER_MM, height * POINTS_PER_MM].map(number).join(" ");
  const named = pictures.map((_, index) => `/I${index} ${6 + index} 0 R`).join(" ");
  const resources = `<< /Font << /F1 5 0 R >> /XObject << ${named} >> >>`;
  return file([
    "<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
    "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
    `<< /Type /Page /Parent 2 0 R /MediaBox [${box}] /Contents 4 0 R /Resources ${resources} >>`,
    `<< /Length ${content.length} >>\nstream\n${content}\nendstream`,
    "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>",
    ...pictures.map(
      (picture) =>
        `<< /Type /XObject /Subtype /Image /ImageMask true /BitsPerComponent 1 /Width ${picture.width} ` +
        `/Height ${picture.height} /Length ${picture.bits.length} >>\nstream\n${characters(picture.bits)}\nendstream`,
    ),
  ]);
}

/**
 * Frame around a rectangle, four rectangles, mm.
 * @param {number} x
 * @param {number} y
 * @param {number} width
 * @param {number} height
 */
function edge(x, y, width, height) {
  const wide = INVERTED_EDGE_MM;
  return [
    [x - wide, y - wide, width + 2 * wide, wide],
    [x - wide, y + height, width + 2 * wide, wide],
    [x - wide, y, wide, height],
    [x + width, y, wide, height],
  ];
}

/** A character a byte. @param {Uint8Array} bytes */
const characters = (bytes) => Array.from(bytes, (byte) => String.fromCharCode(byte)).join("");

/** @param {string[]} objects bodies of objects 1, 2, …; Latin-1, so that characters are bytes */
function file(objects) {
  let text = "%PDF-1.4\n";
  const offsets = objects.map((body, index) => {
    const offset = text.length;
    text += `${index + 1} 0 obj\n${body}\nendobj\n`;
    return offset;
  });
  const table = offsets.map((offset) => `${String(offset).padStart(10, "0")} 00000 n \n`).join("");
  text +=
    `xref\n0 ${objects.length + 1}\n0000000000 65535 f \n${table}` +
    `trailer\n<< /Size ${objects.length + 1} /Root 1 0 R >>\nstartxref\n${text.length}\n%%EOF\n`;
  return Uint8Array.from(text, (character) => character.charCodeAt(0));
}

/** Characters that WinAnsi and Latin-1 have at the same place. */
const LATIN = /^[\x20-\x7e\xa0-\xff]*$/;

/** @param {number} value */
const number = (value) => String(Math.round(value * 1e4) / 1e4);

/** @param {string} words */
const escape = (words) => words.replace(/[\\()]/g, "\\$&");
