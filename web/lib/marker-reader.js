// Markers of every dictionary in one picture: quadrilaterals are read once, and looked up in all dictionaries. Pure.
import { dictionaryOf, isTagFamily } from "./board.js";
import { markerBits } from "./board-drawing.js";
import { homography } from "./homography.js";
import { refineCorner } from "./subpixel.js";

/**
 * @import { Marker } from "./marker-detector.js"
 * @import { Grey } from "./subpixel.js"
 */

/**
 * @typedef {{family: string, border: number, mirrored: boolean, markers: Marker[]}} Reading markers of one family in
 *   one picture; of a mirrored one as they would be in the picture turned back
 */

/** The longest dictionary of each family, those that people use first. */
const FAMILIES = [
  "DICT_4X4_1000",
  "DICT_5X5_1000",
  "DICT_6X6_1000",
  "DICT_APRILTAG_36h11",
  "DICT_7X7_1000",
  "DICT_ARUCO_ORIGINAL",
  "DICT_APRILTAG_36h10",
  "DICT_APRILTAG_25h9",
  "DICT_APRILTAG_16h5",
];
const KALIBR_BORDER = 2; // cells
const CELL_SAMPLES = [0.25, 0.5, 0.75]; // within a cell
const UNIT_SQUARE = [
  [0, 0],
  [1, 0],
  [1, 1],
  [0, 1],
];
const FRAME_PLACES = [0.15, 0.29, 0.43, 0.57, 0.71, 0.85]; // across a marker
const FRAME_DEPTH = 0.05; // within the black frame of the narrowest
const MARKER_WINDOW_SHARE = 0.1; // of a marker's side: half the window of the refinement
const [MIN_WINDOW_PX, MAX_WINDOW_PX] = [2, 5];
const MIN_CONTRAST = 30; // of 255, between the black and the white of a marker

/** Cells a side of the markers of all families, and of their black borders. @type {[number, number][]} */
const SHAPES = [
  ...new Map(
    FAMILIES.flatMap((family) => {
      const { side } = dictionaryOf(family);
      return (isTagFamily(family) ? [1, KALIBR_BORDER] : [1]).map((border) => [
        `${side} ${border}`,
        /** @type {[number, number]} */ ([side, border]),
      ]);
    }),
  ).values(),
];

/**
 * Families and numbers by the cells of a marker, by its side.
 * @type {Map<number, Map<number, {family: string, id: number}[]>>}
 */
const codes = new Map();

/** @param {number} side */
function codesOf(side) {
  const before = codes.get(side);
  if (before) return before;
  /** @type {Map<number, {family: string, id: number}[]>} */
  const found = new Map();
  for (const family of FAMILIES) {
    const dictionary = dictionaryOf(family);
    if (dictionary.side !== side) continue;
    for (let id = 0; id < dictionary.count; id++) {
      const code = codeOf(markerBits(family, id).flat());
      found.set(code, [...(found.get(code) ?? []), { family, id }]);
    }
  }
  codes.set(side, found);
  return found;
}

/** At most 49 cells: fewer than a number's digits. @param {boolean[]} cells */
const codeOf = (cells) => cells.reduce((sum, white) => 2 * sum + (white ? 1 : 0), 0);

/**
 * @param {Grey} image dark markers on white @param {number[][][]} quads corners of dark quadrilaterals, clockwise
 * @returns {Reading[]} most markers first
 */
export function readMarkers(image, quads) {
  /** @type {Map<string, Reading & {found: Map<number, Marker>}>} */
  const readings = new Map();
  for (const quad of quads.map(outwards)) {
    const h = homography(UNIT_SQUARE, quad);
    if (!h || !hasDarkFrame(image, h)) continue;
    /** @type {number[][] | null} */
    let fine = null;
    for (const [side, border] of SHAPES) {
      const cells = readCells(image, h, side, border);
      for (const each of cells ? lookUp(cells, (fine ??= refined(image, quad)), side, border, image.width) : [])
        add(readings, each, border);
    }
  }
  return [...readings.values()]
    .map(({ found, ...reading }) => ({ ...reading, markers: [...found.values()] }))
    .sort((a, b) => b.markers.length - a.markers.length);
}

/**
 * @param {Map<string, Reading & {found: Map<number, Marker>}>} readings
 * @param {{family: string, mirrored: boolean, marker: Marker}} each
 * @param {number} border
 */
function add(readings, { family, mirrored, marker }, border) {
  const key = `${family} ${border} ${mirrored}`;
  const reading = readings.get(key) ?? { family, border, mirrored, markers: [], found: new Map() };
  readings.set(key, reading);
  const other = reading.found.get(marker.id); // the same one within itself: contours run inside and outside of a frame
  if (!other || area(other.corners) < area(marker.corners)) reading.found.set(marker.id, marker);
}

/** Contours run through the outermost pixels, edges half a pixel beyond. @param {number[][]} quad */
function outwards(quad) {
  const [x, y] = [0, 1].map((axis) => quad.reduce((sum, corner) => sum + corner[axis], 0) / 4);
  const side = Math.sqrt(area(quad)) || 1;
  return quad.map((corner) => [x + (corner[0] - x) * (1 + 1 / side), y + (corner[1] - y) * (1 + 1 / side)]);
}

/** @param {number[][]} quad */
const area = ([a, b, c, d]) => Math.abs((c[0] - a[0]) * (d[1] - b[1]) - (c[1] - a[1]) * (d[0] - b[0])) / 2;

/** Corners to a fraction of a pixel, of those that have one there. @param {Grey} image @param {number[][]} quad */
function refined(image, quad) {
  const side = Math.sqrt(area(quad));
  const half = Math.round(Math.min(MAX_WINDOW_PX, Math.max(MIN_WINDOW_PX, MARKER_WINDOW_SHARE * side)));
  return quad.map(([x, y]) => {
    const fine = refineCorner(image, x, y, half);
    return fine && Math.hypot(fine[0] - x, fine[1] - y) < half ? fine : [x, y];
  });
}

/**
 * True if a quadrilateral is dark all along its sides, and brighter somewhere within: most are not.
 * @param {Grey} image
 * @param {number[]} h
 */
function hasDarkFrame(image, h) {
  let [frame, inside] = [0, 0];
  for (const place of FRAME_PLACES) {
    for (const depth of [FRAME_DEPTH, 1 - FRAME_DEPTH])
      frame = Math.max(frame, level(image, h, place, depth), level(image, h, depth, place));
    for (const other of FRAME_PLACES) inside = Math.max(inside, level(image, h, place, other));
  }
  return inside - frame >= MIN_CONTRAST;
}

/**
 * Brightness at a place of the unit square.
 * @param {Grey} image
 * @param {number[]} h
 * @param {number} u
 * @param {number} v
 */
function level({ width, height, data }, h, u, v) {
  const w = h[6] * u + h[7] * v + h[8];
  const [x, y] = [Math.round((h[0] * u + h[1] * v + h[2]) / w), Math.round((h[3] * u + h[4] * v + h[5]) / w)];
  return data[Math.min(height - 1, Math.max(0, y)) * width + Math.min(width - 1, Math.max(0, x))];
}

/**
 * Cells of a marker, without its border; null where it has none.
 * @param {Grey} image @param {number[]} h from the unit square @param {number} side @param {number} border
 * @returns {boolean[] | null} row by row, true: white
 */
function readCells(image, h, side, border) {
  const count = side + 2 * border;
  const levels = new Float64Array(count * count);
  for (let index = 0; index < levels.length; index++) {
    const [column, row] = [index % count, Math.floor(index / count)];
    for (const v of CELL_SAMPLES)
      for (const u of CELL_SAMPLES) levels[index] += level(image, h, (column + u) / count, (row + v) / count);
  }
  const [low, high] = [Math.min(...levels), Math.max(...levels)];
  if (high - low < MIN_CONTRAST * CELL_SAMPLES.length ** 2) return null;
  /** @type {boolean[]} */
  const cells = [];
  for (let index = 0; index < levels.length; index++) {
    const [column, row] = [index % count, Math.floor(index / count)];
    const white = levels[index] > (low + high) / 2;
    const inner = Math.min(column, row, count - 1 - column, count - 1 - row) >= border;
    if (inner) cells.push(white);
    else if (white) return null;
  }
  return cells;
}

/**
 * @param {boolean[]} cells
 * @param {number[][]} quad
 * @param {number} side
 * @param {number} border
 * @param {number} width of the image, px
 * @returns {{family: string, mirrored: boolean, marker: Marker}[]}
 */
function lookUp(cells, quad, side, border, width) {
  const table = codesOf(side);
  /** @type {{family: string, mirrored: boolean, marker: Marker}[]} */
  const found = [];
  for (const mirrored of [false, true]) {
    let turned = mirrored ? cells.map((_, n) => cells[n - (n % side) + side - 1 - (n % side)]) : cells;
    let corners = mirrored ? [1, 0, 3, 2].map((n) => [width - 1 - quad[n][0], quad[n][1]]) : quad;
    for (let quarter = 0; quarter < 4; quarter++) {
      for (const { family, id } of table.get(codeOf(turned)) ?? []) {
        if (border === 1 || isTagFamily(family)) found.push({ family, mirrored, marker: { id, corners } });
      }
      const before = turned;
      turned = before.map((_, n) => before[(n % side) * side + side - 1 - Math.floor(n / side)]);
      corners = [1, 2, 3, 0].map((n) => corners[n]);
    }
  }
  return found;
}
