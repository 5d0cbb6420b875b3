// Calibration boards (ChArUco, chessboard, AprilGrid, circles): valid layouts, and the positions of their corners.
// Frame: x right, y down, unit = one square, of an AprilGrid one side of a tag.

/**
 * Number of markers of the dictionaries, and cells a side; vendor/dictionaries.js lists the white cells.
 * @type {Record<string, {side: number, count: number}>}
 */
const SIZES = {
  "4X4": { side: 4, count: 1000 },
  "5X5": { side: 5, count: 1000 },
  "6X6": { side: 6, count: 1000 },
  "7X7": { side: 7, count: 1000 },
  ARUCO_ORIGINAL: { side: 5, count: 1024 },
  APRILTAG_16h5: { side: 4, count: 30 },
  APRILTAG_25h9: { side: 5, count: 35 },
  APRILTAG_36h10: { side: 6, count: 2320 },
  APRILTAG_36h11: { side: 6, count: 587 },
};
const COUNTS = [50, 100, 250, 1000]; // of markers, that OpenCV cuts its own dictionaries to
const [MIN_SQUARES, MAX_SQUARES] = [3, 50]; // a side, that the service takes
const MIN_CIRCLES = 2; // a side
const MAX_CORNERS = 2401; // of a board, likewise
const MIN_CORNERS = 6;
const [MIN_TAG_SPACING, MAX_TAG_SPACING] = [0.05, 2]; // of a tag's side
export const DEFAULT_TAG_SPACING = 0.3;
/** Surface of a board that a screen shows. @type {"screen"} */
const SCREEN = "screen";
/** Kinds of boards. @type {("charuco" | "chessboard" | "aprilgrid")[]} */
export const KINDS = ["charuco", "chessboard", "aprilgrid"];
/** Kinds of grids of circles, which pages draw, and only the command detects. */
export const CIRCLES = ["circles", "asymmetric_circles"];

/**
 * @typedef {object} Board
 * @property {"charuco" | "chessboard" | "aprilgrid" | "circles" | "asymmetric_circles"} [kind] charuco where it is
 *   missing
 * @property {[number, number]} squares columns, rows; of an AprilGrid its tags, of circles these. The unit of circles
 *   is the distance between rows. In rows of an asymmetric grid they are two units apart, and odd rows are shifted by
 *   one
 * @property {number} marker_ratio marker side / square side; of circles diameter / unit
 * @property {string} dictionary "DICT_4X4_50"
 * @property {boolean} legacy layout of OpenCV before 4.6: boards of an even number of rows start with a white square
 * @property {boolean} [inverted] white where others are black
 * @property {number} [tag_spacing] gap / side of a tag, of an AprilGrid
 * @property {"screen" | null} [surface] "screen" where a screen is known to show it: flat and square
 *
 * @typedef {import("../vendor/api.js").Board & Board} SentBoard as the service takes it
 *
 * @typedef {{code: "kind" | "circles" | "squares" | "few_corners" | "many_corners" | "ratio" | "spacing" | "dictionary"
 *   | "family" | "few_markers",
 *   values: Record<string, string | number>}} Problem
 *   why a board cannot be; problem.js has the words
 */

/** The names of the marker dictionaries, as OpenCV has them. */
export const DICTIONARIES = Object.keys(SIZES).flatMap((size) =>
  isCut(size) ? COUNTS.map((count) => `DICT_${size}_${count}`) : [`DICT_${size}`],
);

/** @type {SentBoard} */
export const DEFAULT_BOARD = { squares: [9, 6], marker_ratio: 0.65, dictionary: "DICT_4X4_50", legacy: false };

/**
 * The board an address asks for: `kind=chessboard`, `squares=9x6`, `marker_ratio`, `dictionary`, `legacy=true`,
 * `inverted=true`, `tag_spacing`, `surface=screen`; of each the default where it asks for none.
 * @param {URLSearchParams} query
 * @param {{circles?: boolean}} [options] circles: whether the board may be one of circles, which no page detects
 * @returns {{board: SentBoard, problem: Problem | null}} problem: why it is the default board all the same
 */
export function boardFrom(query, { circles = false } = {}) {
  const [squares, ratio, spacing] = [query.get("squares"), query.get("marker_ratio"), query.get("tag_spacing")];
  const kind = /** @type {Board["kind"]} */ (query.get("kind") ?? "charuco");
  const flag = (/** @type {string} */ name) => ["true", "1"].includes(query.get(name) ?? "");
  const asked = /** @type {SentBoard} */ ({
    ...(kind !== "charuco" && { kind }),
    squares: /** @type {[number, number]} */ ((squares ?? DEFAULT_BOARD.squares.join("x")).split("x").map(Number)),
    marker_ratio: ratio === null ? DEFAULT_BOARD.marker_ratio : Number(ratio),
    dictionary: query.get("dictionary") ?? (kind === "aprilgrid" ? "DICT_APRILTAG_36h11" : DEFAULT_BOARD.dictionary),
    legacy: flag("legacy"),
    ...(flag("inverted") && { inverted: true }),
    ...(kind === "aprilgrid" && { tag_spacing: spacing === null ? DEFAULT_TAG_SPACING : Number(spacing) }),
    ...(query.get("surface") === SCREEN && { surface: SCREEN }),
  });
  const problem = isCircles(asked) && !circles ? onlyCommand(asked) : impossible(asked);
  return { board: problem ? DEFAULT_BOARD : asked, problem };
}

/**
 * The parameters that lead to this board.
 * @param {Board} board
 * @returns {URLSearchParams} without those of the default
 */
export function boardQuery({
  kind = "charuco",
  squares,
  marker_ratio,
  dictionary,
  legacy,
  inverted,
  tag_spacing: spacing,
  surface,
}) {
  const query = new URLSearchParams();
  if (kind !== "charuco") query.set("kind", kind);
  if (squares.join("x") !== DEFAULT_BOARD.squares.join("x")) query.set("squares", squares.join("x"));
  if ((kind === "charuco" || CIRCLES.includes(kind)) && marker_ratio !== DEFAULT_BOARD.marker_ratio)
    query.set("marker_ratio", String(marker_ratio));
  if (["charuco", "aprilgrid"].includes(kind) && dictionary !== DEFAULT_BOARD.dictionary)
    query.set("dictionary", dictionary);
  if (legacy) query.set("legacy", "true");
  if (inverted) query.set("inverted", "true");
  if (kind === "aprilgrid" && spacing !== DEFAULT_TAG_SPACING) query.set("tag_spacing", String(spacing));
  if (surface) query.set("surface", surface);
  return query;
}

/** True if two boards are the same drawing, on whatever surface. @param {Board} a @param {Board} b */
export const isSameBoard = (a, b) => drawing(a) === drawing(b);

/** @param {Board} board */
const drawing = (board) => boardQuery({ ...board, surface: null }).toString();

/** Kind of a board. @param {Board} board */
export const kindOf = ({ kind }) => kind ?? "charuco";

/** True for a grid of circles. @param {Board} board */
export const isCircles = (board) => CIRCLES.includes(kindOf(board));

/** Command that calibrates from photos of a grid of circles; the service takes none. @param {Board} board */
export function circlesCommand(board) {
  const inverted = board.inverted ? " --inverted" : "";
  const options = `--kind ${kindOf(board)} --squares ${board.squares.join("x")} --marker-ratio ${board.marker_ratio}`;
  return `calibdb calibrate photos/ --offline ${options}${inverted}`;
}

/** @param {Board} board @returns {Problem} */
function onlyCommand(board) {
  return impossible(board) ?? { code: "circles", values: { command: circlesCommand(board) } };
}

/**
 * Reason why there is no such board, by the limits of the service; null where there may be.
 * @param {Board} board
 * @returns {Problem | null}
 */
export function impossible(board) {
  const { squares, marker_ratio: ratio, dictionary, tag_spacing: spacing = DEFAULT_TAG_SPACING } = board;
  const kind = kindOf(board);
  if (![...KINDS, ...CIRCLES].includes(kind)) return { code: "kind", values: { kind } };
  const fewest = kind === "aprilgrid" ? 1 : isCircles(board) ? MIN_CIRCLES : MIN_SQUARES;
  if (
    squares.length !== 2 ||
    !squares.every((count) => Number.isInteger(count) && count >= fewest && count <= MAX_SQUARES)
  ) {
    return { code: "squares", values: { fewest } };
  }
  const count = cornerCount(board);
  if (count < MIN_CORNERS) return { code: "few_corners", values: {} };
  if (count > MAX_CORNERS) return { code: "many_corners", values: { most: MAX_CORNERS } };
  if (!(ratio >= 0.3 && ratio <= 0.95)) return { code: "ratio", values: {} };
  if (!DICTIONARIES.includes(dictionary)) return { code: "dictionary", values: { dictionary } };
  if (kind === "chessboard" || isCircles(board)) return null;
  if (kind === "aprilgrid") {
    if (!isTagFamily(dictionary)) return { code: "family", values: { dictionary } };
    if (!(spacing >= MIN_TAG_SPACING && spacing <= MAX_TAG_SPACING)) return { code: "spacing", values: {} };
  }
  const [has, needed] = [dictionaryOf(dictionary).count, markers(board).length];
  return needed > has ? { code: "few_markers", values: { dictionary, has, needed } } : null;
}

/** Number of corners that are measured. @param {Board} board */
function cornerCount({ kind, squares: [columns, rows] }) {
  if (CIRCLES.includes(kind ?? "")) return columns * rows;
  return kind === "aprilgrid" ? 4 * columns * rows : (columns - 1) * (rows - 1);
}

/** Width and height, board units. @param {Board} board @returns {[number, number]} */
export function sizeOf({ kind, squares: [columns, rows], tag_spacing: spacing = DEFAULT_TAG_SPACING }) {
  if (kind === "circles") return [columns + 1, rows + 1];
  if (kind === "asymmetric_circles") return [2 * columns + 1, rows + 1];
  return kind === "aprilgrid" ? [columns + (columns - 1) * spacing, rows + (rows - 1) * spacing] : [columns, rows];
}

/**
 * Corners in the order of their ids: row by row; of an AprilGrid tag by tag from the lower left, anticlockwise from the
 * tag's lower left.
 * @param {Board} board @returns {[number, number][]}
 */
export function corners({ kind, squares: [columns, rows], tag_spacing: spacing = DEFAULT_TAG_SPACING }) {
  /** @type {[number, number][]} */
  const points = [];
  if (kind === "aprilgrid") {
    for (let tag = 0; tag < columns * rows; tag++) {
      const [x, y] = [(tag % columns) * (1 + spacing), -Math.floor(tag / columns) * (1 + spacing)];
      points.push([x, y], [x + 1, y], [x + 1, y - 1], [x, y - 1]);
    }
    return points.map(([x, y]) => [x, y || 0]);
  }
  if (CIRCLES.includes(kind ?? "")) {
    const x = (/** @type {number} */ column, /** @type {number} */ row) =>
      kind === "circles" ? column + 1 : 2 * column + (row % 2) + 1;
    for (let row = 0; row < rows; row++)
      for (let column = 0; column < columns; column++) points.push([x(column, row), row + 1]);
    return points;
  }
  for (let y = 1; y < rows; y++) for (let x = 1; x < columns; x++) points.push([x, y]);
  return points;
}

/** The board's edge, clockwise from the top left. @param {Board} board @returns {[number, number][]} */
export function outline(board) {
  const [width, height] = sizeOf(board);
  const top = board.kind === "aprilgrid" ? -height : 0;
  return [
    [0, top],
    [width, top],
    [width, top + height],
    [0, top + height],
  ];
}

/** True if a square is black. @param {Board} board @param {number} x column @param {number} y row */
export function isBlack({ squares: [, rows], legacy }, x, y) {
  return (x + y + (legacy && rows % 2 === 0 ? 1 : 0)) % 2 === 0;
}

/** True if a dictionary's markers are AprilTags. @param {string} dictionary */
export const isTagFamily = (dictionary) => dictionary.startsWith("DICT_APRILTAG_");

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

/**
 * Markers with the square they are in, in the order of their ids; of an AprilGrid rows count from below.
 * @param {Board} board
 */
export function markers(board) {
  const [columns, rows] = board.squares;
  /** @type {{id: number, x: number, y: number}[]} */
  const found = [];
  if (board.kind === "chessboard" || isCircles(board)) return found;
  for (let y = 0; y < rows; y++) {
    for (let x = 0; x < columns; x++)
      if (board.kind === "aprilgrid" || !isBlack(board, x, y)) found.push({ id: found.length, x, y });
  }
  return found;
}
