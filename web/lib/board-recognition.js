// Recognition of a board in pictures of which nobody said what board they show. Pure; the worker looks, this concludes.
//
// In a picture the markers of each family are looked for, in black and in white. Ids and places of those found fit the rows
// and columns of one board only (marker-grid.js). Several pictures together tell the number of rows: no single one need
// show the whole board. The ratio of marker and square is measured through the homography. Where there are no markers, a
// lattice of saddle points is a chessboard (chessboard-lattice.js).
import { DEFAULT_TAG_SPACING, dictionaryOf, impossible, DICTIONARIES, markers } from "./board.js";
import { fitGrid, median, squareOf } from "./marker-grid.js";

/**
 * @typedef {import("./board.js").SentBoard} SentBoard
 * @typedef {import("./marker-detector.js").Marker} Marker
 *
 * @typedef {object} Sighting what one picture shows
 * @property {string | null} family dictionary of the markers found
 * @property {Marker[]} markers
 * @property {boolean} inverted whether black and white are swapped
 * @property {{squares: [number, number], points: number[][], isPlain: boolean} | null} chessboard
 * @property {[number, number]} size px
 */

/** The longest dictionary of each family, those that people use first. */
export const FAMILIES = [
  "DICT_4X4_1000", "DICT_5X5_1000", "DICT_6X6_1000", "DICT_APRILTAG_36h11", "DICT_7X7_1000", "DICT_ARUCO_ORIGINAL", "DICT_APRILTAG_36h10",
  "DICT_APRILTAG_25h9", "DICT_APRILTAG_16h5",
];
/** Ratios of marker and square that boards are sold and drawn with. */
const USUAL_RATIOS = [0.5, 0.6, 0.65, 0.7, 0.75, 0.8];
const USUAL_SPACINGS = [0.2, 0.25, DEFAULT_TAG_SPACING, 0.4, 0.5];
const MAX_ROUNDING = 0.025; // from a usual ratio or spacing: corners of small markers are known to a pixel
const RATIO_RANGE = [0.3, 0.95]; // that the service takes

/** @param {string} family */
export const isTagFamily = (family) => family.startsWith("DICT_APRILTAG_");

/** Whether a picture tells the board well enough that no other family need be looked for. @param {Sighting} sighting */
export function isTelling({ family, markers: found }) {
  return family !== null && fitGrid(found, isTagFamily(family)) !== null;
}

/**
 * The board that pictures show.
 * @param {Sighting[]} sightings
 * @returns {{board: SentBoard, picture: number} | null} picture: number of the one that shows it best; null: no board is recognised
 */
export function recognise(sightings) {
  const fits = sightings.flatMap((sighting, picture) => {
    const found = sighting.family === null ? null : fitGrid(sighting.markers, isTagFamily(sighting.family));
    return found ? [{ ...sighting, ...found, family: /** @type {string} */ (sighting.family), picture }] : [];
  });
  if (fits.length === 0) return recogniseChessboard(sightings);
  const keyOf = (/** @type {typeof fits[0]} */ each) => [each.family, each.kind, each.columns, each.markerFirst, each.inverted].join();
  const groups = group(fits, keyOf);
  const weight = (/** @type {typeof fits} */ list) => list.reduce((sum, { inliers }) => sum + inliers.length, 0);
  const [members] = [...groups.values()].sort((a, b) => weight(b) - weight(a));
  const board = boardOf(members);
  const best = members.reduce((a, b) => (b.inliers.length > a.inliers.length ? b : a));
  return board && impossible(board) === null ? { board, picture: best.picture } : null;
}

/** @template F @param {F[]} list @param {(each: F) => string} keyOf @returns {Map<string, F[]>} */
function group(list, keyOf) {
  const found = new Map();
  for (const each of list) found.set(keyOf(each), [...(found.get(keyOf(each)) ?? []), each]);
  return found;
}

/** @param {(import("./marker-grid.js").GridFit & {family: string, inverted: boolean})[]} members fits that agree @returns {SentBoard | null} */
function boardOf(members) {
  const [{ kind, columns, markerFirst, family, inverted }] = members;
  const side = median(members.flatMap((each) => each.inliers.map(() => each.side)));
  let rows = 1 + Math.max(...members.flatMap((each) => each.inliers.map(({ id }) => squareOf(each, id)[1])));
  const common = { legacy: false, ...(inverted && { inverted }) };
  if (kind === "aprilgrid") {
    const grid = { kind, squares: [columns, rows], marker_ratio: 0.65, dictionary: family, ...common, tag_spacing: nearest(1 / side - 1, USUAL_SPACINGS) };
    return /** @type {SentBoard} */ (grid);
  }
  // A first square with a marker is the old layout, which only boards of an even number of rows have: the last one was not seen.
  if (markerFirst && rows % 2 === 1) rows += 1;
  const ratio = Math.min(RATIO_RANGE[1], Math.max(RATIO_RANGE[0], nearest(side, USUAL_RATIOS)));
  /** @type {import("./board.js").Board} */
  const board = { squares: [columns, rows], marker_ratio: ratio, dictionary: family, ...common, legacy: markerFirst };
  return /** @type {SentBoard} */ ({ ...board, dictionary: shortest(family, markers(board).length) });
}

/** The shortest dictionary of a family that holds so many markers. @param {string} family @param {number} count */
function shortest(family, count) {
  const { size } = dictionaryOf(family);
  return DICTIONARIES.find((name) => dictionaryOf(name).size === size && dictionaryOf(name).count >= count) ?? family;
}

/** @param {number} value @param {number[]} usual @returns {number} the usual one, or the value to two digits */
function nearest(value, usual) {
  const [best] = [...usual].sort((a, b) => Math.abs(a - value) - Math.abs(b - value));
  return Math.abs(best - value) <= MAX_ROUNDING ? Math.round(1000 * best) / 1000 : Math.round(100 * value) / 100;
}

/** Squares that most pictures agree on; a single picture is believed. @param {Sighting[]} sightings @returns {{board: SentBoard, picture: number} | null} */
function recogniseChessboard(sightings) {
  const seen = sightings.flatMap(({ chessboard }, picture) => (chessboard ? [{ ...chessboard, picture }] : []));
  if (seen.length === 0) return null;
  const groups = group(seen, ({ squares }) => squares.join());
  const [members] = [...groups.values()].sort((a, b) => b.length - a.length || b[0].points.length - a[0].points.length);
  const [{ squares, picture }] = members;
  /** @type {SentBoard} */
  const board = { kind: "chessboard", squares, marker_ratio: 0.65, dictionary: "DICT_4X4_50", legacy: false };
  return impossible(board) === null ? { board, picture } : null;
}
