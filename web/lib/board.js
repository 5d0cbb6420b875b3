// ChArUco boards: valid layouts, and the positions of their corners. Frame: x right, y down, unit = one square.

/**
 * Number of markers of the dictionaries, and cells a side; dictionaries.js lists the white cells.
 * @type {Record<string, {side: number, count: number}>}
 */
const SIZES = {
  "4X4": { side: 4, count: 1000 }, "5X5": { side: 5, count: 1000 }, "6X6": { side: 6, count: 1000 }, "7X7": { side: 7, count: 1000 },
  ARUCO_ORIGINAL: { side: 5, count: 1024 },
  APRILTAG_16h5: { side: 4, count: 30 }, APRILTAG_25h9: { side: 5, count: 35 },
  APRILTAG_36h10: { side: 6, count: 2320 }, APRILTAG_36h11: { side: 6, count: 587 },
};
const COUNTS = [50, 100, 250, 1000]; // of markers, that OpenCV cuts its own dictionaries to
const [FEWEST_SQUARES, MOST_SQUARES] = [3, 50]; // a side, that the service takes

/**
 * @typedef {object} Board
 * @property {[number, number]} squares columns, rows
 * @property {number} marker_ratio marker side / square side
 * @property {string} dictionary "DICT_4X4_50"
 * @property {boolean} legacy layout of OpenCV before 4.6: boards of an even number of rows start with a white square
 *
 * @typedef {{code: "squares" | "few_corners" | "ratio" | "dictionary" | "few_markers", values: Record<string, string | number>}} Problem
 *   why a board cannot be; problem.js has the words
 */

/** The names of the marker dictionaries, as OpenCV has them. */
export const DICTIONARIES = Object.keys(SIZES).flatMap((size) =>
  (isCut(size) ? COUNTS.map((count) => `DICT_${size}_${count}`) : [`DICT_${size}`]));

/** @type {Required<import("../vendor/api.js").Board>} */
export const DEFAULT_BOARD = { squares: [9, 6], marker_ratio: 0.65, dictionary: "DICT_4X4_50", legacy: false };

/**
 * The board an address asks for: `squares=9x6`, `marker_ratio`, `dictionary`, `legacy=true`; of each the default where it
 * asks for none.
 * @param {URLSearchParams} query
 * @returns {{board: Required<import("../vendor/api.js").Board>, problem: Problem | null}} problem: why it is the default
 *   board all the same
 */
export function boardFrom(query) {
  const [squares, ratio] = [query.get("squares"), query.get("marker_ratio")];
  const sides = (squares ?? DEFAULT_BOARD.squares.join("x")).split("x").map(Number);
  const asked = {
    squares: /** @type {[number, number]} */ (sides),
    marker_ratio: ratio === null ? DEFAULT_BOARD.marker_ratio : Number(ratio),
    dictionary: query.get("dictionary") ?? DEFAULT_BOARD.dictionary,
    legacy: ["true", "1"].includes(query.get("legacy") ?? ""),
  };
  const problem = impossible(asked);
  return { board: problem ? DEFAULT_BOARD : /** @type {typeof DEFAULT_BOARD} */ (asked), problem };
}

/**
 * The parameters that lead to this board.
 * @param {Board} board
 * @returns {URLSearchParams} without those of the default
 */
export function boardQuery({ squares, marker_ratio, dictionary, legacy }) {
  const query = new URLSearchParams();
  if (squares.join("x") !== DEFAULT_BOARD.squares.join("x")) query.set("squares", squares.join("x"));
  if (marker_ratio !== DEFAULT_BOARD.marker_ratio) query.set("marker_ratio", String(marker_ratio));
  if (dictionary !== DEFAULT_BOARD.dictionary) query.set("dictionary", dictionary);
  if (legacy) query.set("legacy", "true");
  return query;
}

/**
 * Why there is no such board, by the limits of the service; null where there may be.
 * @param {Board} board
 * @returns {Problem | null}
 */
function impossible(board) {
  const { squares, marker_ratio, dictionary } = board;
  if (squares.length !== 2 || !squares.every((count) => Number.isInteger(count) && count >= FEWEST_SQUARES && count <= MOST_SQUARES)) {
    return { code: "squares", values: {} };
  }
  if ((squares[0] - 1) * (squares[1] - 1) < 6) return { code: "few_corners", values: {} };
  if (!(marker_ratio >= 0.3 && marker_ratio <= 0.95)) return { code: "ratio", values: {} };
  if (!DICTIONARIES.includes(dictionary)) return { code: "dictionary", values: { dictionary } };
  const { count } = dictionaryOf(dictionary);
  const needed = markers(board).length;
  return needed > count ? { code: "few_markers", values: { dictionary, has: count, needed } } : null;
}

/** Inner corners in the order of their ids: row by row. @param {Board} board @returns {[number, number][]} */
export function corners({ squares: [columns, rows] }) {
  /** @type {[number, number][]} */
  const points = [];
  for (let y = 1; y < rows; y++) for (let x = 1; x < columns; x++) points.push([x, y]);
  return points;
}

/** The board's edge, clockwise from the origin. @param {Board} board @returns {[number, number][]} */
export function outline({ squares: [columns, rows] }) {
  return [[0, 0], [columns, 0], [columns, rows], [0, rows]];
}

/** Is this square black? @param {Board} board @param {number} x column @param {number} y row */
export function isBlack({ squares: [, rows], legacy }, x, y) {
  return (x + y + (legacy && rows % 2 === 0 ? 1 : 0)) % 2 === 0;
}

/** @param {string} dictionary "DICT_4X4_50" @returns {{size: string, side: number, count: number}} throws RangeError */
export function dictionaryOf(dictionary) {
  if (!DICTIONARIES.includes(dictionary)) throw new RangeError(`unknown marker dictionary ${dictionary}`);
  const name = dictionary.slice("DICT_".length);
  const [size, number] = name in SIZES ? [name, undefined] : name.split("_");
  const { side, count } = SIZES[size];
  return { size, side, count: number === undefined ? count : Number(number) };
}

/** Do dictionaries of this size come in several lengths, each the beginning of the next? @param {string} size */
function isCut(size) {
  return /^\dX\d$/.test(size);
}

/** Markers with the square they are in, in the order of their ids. @param {Board} board */
export function markers(board) {
  const [columns, rows] = board.squares;
  /** @type {{id: number, x: number, y: number}[]} */
  const found = [];
  for (let y = 0; y < rows; y++) {
    for (let x = 0; x < columns; x++) if (!isBlack(board, x, y)) found.push({ id: found.length, x, y });
  }
  return found;
}
