// Recognition of an unknown board in pictures. Pure: the worker detects, this module infers the board.
//
// The detector searches each picture for the markers of all families: black, white, and mirrored. Ids and places of
// the markers fit the rows and columns of one board only (marker-grid.js). The number of rows follows from several
// pictures, so none has to show the whole board. The ratio of marker and square is measured through the homography.
// Without markers, a lattice of saddle points is a chessboard (chessboard-lattice.js).
import {
  DEFAULT_TAG_SPACING,
  dictionaryOf,
  impossible,
  isSameBoard,
  isTagFamily,
  DICTIONARIES,
  markers,
} from "./board.js";
import { fitGrid, median, squareOf } from "./marker-grid.js";
import { centreOf } from "./marker-detector.js";

/**
 * @import { Board, SentBoard } from "./board.js"
 * @import { Marker } from "./marker-detector.js"
 * @import { GridFit } from "./marker-grid.js"
 */

/**
 * @typedef {object} Sighting what one picture shows
 * @property {string | null} family dictionary of the markers found
 * @property {Marker[]} markers
 * @property {boolean} inverted whether black and white are swapped
 * @property {boolean} mirrored whether the picture is: then the markers are those of the picture turned back
 * @property {{squares: [number, number], points: number[][], isPlain: boolean} | null} chessboard
 * @property {[number, number]} size px
 */

/** Ratios of marker and square that boards are sold and drawn with. */
const USUAL_RATIOS = [0.5, 0.6, 0.65, 0.7, 0.75, 0.8];
const USUAL_SPACINGS = [0.2, 0.25, DEFAULT_TAG_SPACING, 0.4, 0.5];
const MAX_ROUNDING = 0.025; // from a usual ratio or spacing: corners of small markers are known to a pixel
// from the outermost corner to the picture's edge: within, the square there may be cut off
const MAX_EDGE_PITCHES = 1.2;
const MIN_AGREEMENT = 0.75; // of the pictures, on the number of squares
const RATIO_RANGE = [0.3, 0.95]; // that the service takes

/** True if a picture identifies the board, so that no other family is searched. @param {Sighting} sighting */
export function isTelling({ family, markers: found }) {
  return family !== null && fitGrid(found, isTagFamily(family)) !== null;
}

/**
 * @typedef {object} Recognised
 * @property {SentBoard} board
 * @property {number} picture number of the one that shows it best
 * @property {number} support pictures that show this board
 * @property {boolean} mirrored whether the pictures are
 * @property {boolean} isCut part of it may be out of the picture, or the pictures differ: there may be more squares
 */

/**
 * The board that pictures show.
 * @param {Sighting[]} sightings
 * @returns {Recognised | null} null: no board is recognised
 */
export function recognise(sightings) {
  const fits = sightings.flatMap((sighting, picture) => {
    const found = sighting.family === null ? null : fitGrid(sighting.markers, isTagFamily(sighting.family));
    return found ? [{ ...sighting, ...found, family: /** @type {string} */ (sighting.family), picture }] : [];
  });
  if (fits.length === 0) return recogniseChessboard(sightings);
  const keyOf = (/** @type {typeof fits[0]} */ each) =>
    [each.family, each.kind, each.columns, each.markerFirst, each.inverted, each.mirrored].join();
  const groups = group(fits, keyOf);
  const weight = (/** @type {typeof fits} */ list) => list.reduce((sum, { inliers }) => sum + inliers.length, 0);
  const [members] = [...groups.values()].sort((a, b) => weight(b) - weight(a));
  const board = boardOf(members);
  const best = members.reduce((a, b) => (b.inliers.length > a.inliers.length ? b : a));
  if (!board || impossible(board) !== null) return null;
  const { mirrored } = best;
  return {
    board,
    picture: best.picture,
    support: members.length,
    mirrored,
    isCut: members.every((each) => reachesEdge(each.inliers.map(centreOf), each.size)),
  };
}

/**
 * True if a board may be the upper part of another one, whose other rows were not seen.
 * @param {SentBoard} part
 * @param {SentBoard} whole
 */
export function isPartOf(part, whole) {
  const [columns, rows] = whole.squares;
  const isLower = part.squares[0] === columns && part.squares[1] < rows;
  return isLower && isSameBoard({ ...part, squares: whole.squares, dictionary: whole.dictionary }, whole);
}

/**
 * True if a board may extend beyond the picture's edge.
 * @param {number[][]} points px, of corners or markers
 * @param {[number, number]} size px
 */
function reachesEdge(points, [width, height]) {
  const pitch = median(
    points.map(([x, y], n) => Math.min(...points.filter((_, m) => m !== n).map(([u, v]) => Math.hypot(u - x, v - y)))),
  );
  return points.some(([x, y]) => Math.min(x, y, width - 1 - x, height - 1 - y) < MAX_EDGE_PITCHES * pitch);
}

/** @template F @param {F[]} list @param {(each: F) => string} keyOf @returns {Map<string, F[]>} */
function group(list, keyOf) {
  const found = new Map();
  for (const each of list) found.set(keyOf(each), [...(found.get(keyOf(each)) ?? []), each]);
  return found;
}

/**
 * @param {(GridFit & {family: string, inverted: boolean})[]} members fits that agree
 * @returns {SentBoard | null}
 */
function boardOf(members) {
  const [{ kind, columns, markerFirst, family, inverted }] = members;
  const side = median(members.flatMap((each) => each.inliers.map(() => each.side)));
  let rows = 1 + Math.max(...members.flatMap((each) => each.inliers.map(({ id }) => squareOf(each, id)[1])));
  const common = { legacy: false, ...(inverted && { inverted }) };
  if (kind === "aprilgrid") {
    const grid = {
      kind,
      squares: [columns, rows],
      marker_ratio: 0.65,
      dictionary: family,
      ...common,
      tag_spacing: nearest(spacingOf(members), USUAL_SPACINGS),
    };
    return /** @type {SentBoard} */ (grid);
  }
  // A first square with a marker is the old layout, which only boards of an even number of rows have: the last one was
  // not seen.
  if (markerFirst && rows % 2 === 1) rows += 1;
  const ratio = Math.min(RATIO_RANGE[1], Math.max(RATIO_RANGE[0], nearest(side, USUAL_RATIOS)));
  /** @type {Board} */
  const board = { squares: [columns, rows], marker_ratio: ratio, dictionary: family, ...common, legacy: markerFirst };
  return /** @type {SentBoard} */ ({ ...board, dictionary: shortest(family, markers(board).length) });
}

/**
 * Gap between the tags of an AprilGrid / their side, from neighbours: a wide lens bends the lattice as a whole.
 * @param {GridFit[]} members
 */
function spacingOf(members) {
  return median(
    members.flatMap((fit) => {
      const places = new Map(fit.inliers.map((marker) => [squareOf(fit, marker.id).join(), marker]));
      return fit.inliers.flatMap((marker) => {
        const [column, row] = squareOf(fit, marker.id);
        const neighbours = [
          [column + 1, row],
          [column, row + 1],
        ].flatMap((place) => places.get(place.join()) ?? []);
        return neighbours.map((other) => {
          const [a, b] = [centreOf(marker), centreOf(other)];
          const apart = Math.hypot(b[0] - a[0], b[1] - a[1]);
          const reach = (/** @type {Marker} */ { corners }, /** @type {number[]} */ [x, y]) =>
            Math.max(
              ...corners.map((corner, n) => {
                const next = corners[(n + 1) % 4];
                return (
                  Math.abs(
                    ((corner[0] + next[0]) / 2 - x) * (b[0] - a[0]) + ((corner[1] + next[1]) / 2 - y) * (b[1] - a[1]),
                  ) / apart
                );
              }),
            );
          return apart / (reach(marker, a) + reach(other, b)) - 1;
        });
      });
    }),
  );
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

/**
 * Squares that most pictures agree on; a single picture is believed.
 * @param {Sighting[]} sightings
 * @returns {Recognised | null}
 */
function recogniseChessboard(sightings) {
  // What is not plain is another board, whose markers were not read.
  const seen = sightings.flatMap(({ chessboard, size }, picture) =>
    chessboard?.isPlain ? [{ ...chessboard, size, picture }] : [],
  );
  if (seen.length === 0) return null;
  const groups = group(seen, ({ squares }) => squares.join());
  const [members] = [...groups.values()].sort((a, b) => b.length - a.length || b[0].points.length - a[0].points.length);
  const [{ squares, picture }] = members;
  /** @type {SentBoard} */
  const board = { kind: "chessboard", squares, marker_ratio: 0.65, dictionary: "DICT_4X4_50", legacy: false };
  if (impossible(board) !== null) return null;
  const isCut =
    members.length < MIN_AGREEMENT * seen.length || members.every((each) => reachesEdge(each.points, each.size));
  return { board, picture, support: members.length, mirrored: false, isCut };
}
