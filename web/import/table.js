// A table of corners as mrcal-calibrate-cameras reads it, corners.vnl: a line for every corner of every picture. Pure.
import { MalformedError } from "./grid.js";

/** @import { View } from "./grid.js" */

const MAX_TABLE_VIEWS = 1000;

/**
 * True if a text looks like such a table: its first line of data has a name and two places.
 * @param {string} text
 */
export function isTable(text) {
  const line = /^(?![^\S\n]*(?:#|$)).*$/m.exec(text)?.[0] ?? "";
  const [, x, y] = line.trim().split(/\s+/);
  const place = (/** @type {string | undefined} */ field) =>
    field === "-" || (field !== undefined && Number.isFinite(Number(field)));
  return place(x) && place(y);
}

/**
 * The corners of the board that the table itself names in a comment, "# 8 x 5 corners", as calibDB writes it.
 * @param {string} text
 * @returns {[number, number] | null}
 */
export function squaresIn(text) {
  const found = /^#[ \t]*(\d{1,2}) x (\d{1,2}) corners\b/m.exec(text);
  return found ? [Number(found[1]) + 1, Number(found[2]) + 1] : null;
}

/**
 * @param {string} text @param {[number, number]} squares columns and rows of the board
 * @returns {View[]} throws MalformedError
 */
export function table(text, [columns, rows]) {
  const corners = (columns - 1) * (rows - 1);
  /** @type {Map<string, {lines: number, blank: number, view: View}>} */
  const pictures = new Map();
  for (const [index, line] of text.split(/\r?\n/).entries()) {
    const fields = line.trim().split(/\s+/);
    if (fields[0] === "" || fields[0].startsWith("#")) continue;
    const [name, x, y, level] = fields;
    if (y === undefined) throw new MalformedError("fields", { line: index + 1 });
    const picture = pictures.get(name) ?? { lines: 0, blank: 0, view: { name, object: [], image: [] } };
    pictures.set(name, picture);
    if (pictures.size > MAX_TABLE_VIEWS) throw new MalformedError("many", { most: MAX_TABLE_VIEWS });
    const corner = picture.lines++;
    if (x === "-" || y === "-" || level === "-" || level === "-1") {
      picture.blank++; // not seen
      continue;
    }
    const place = [Number(x), Number(y)];
    if (!place.every(Number.isFinite)) throw new MalformedError("fields", { line: index + 1 });
    picture.view.object.push([(corner % (columns - 1)) + 1, Math.floor(corner / (columns - 1)) + 1, 0]);
    picture.view.image.push(place);
  }
  // A picture without a board is a single line, `img.jpg - - -`.
  const wrong = [...pictures].find(([, { lines, blank }]) => lines !== corners && !(lines === 1 && blank === 1));
  if (wrong) throw new MalformedError("lines", { name: wrong[0].slice(0, 80), lines: wrong[1].lines, corners });
  return [...pictures.values()].map(({ view }) => view).filter(({ image }) => image.length > 0);
}
