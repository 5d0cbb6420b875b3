// A calibration file: of which kind it is, and what in it can be used here. Pure.
import { DEFAULT_BOARD } from "../lib/board.js";
import { grid, MalformedError } from "./grid.js";
import { cameraMatrix, isPhotonVision, photonVision } from "./json.js";
import { isTable, squaresIn, table } from "./table.js";
import { cameraIn } from "./text.js";
import { NAME } from "../lib/camera-name.js";

/**
 * @typedef {import("./grid.js").Numbered} Numbered
 * @typedef {import("./grid.js").View} View
 *
 * @typedef {object} Keypoints
 * @property {"keypoints"} kind
 * @property {[number, number]} size of the pictures, px
 * @property {View[]} views
 *
 * @typedef {object} Table
 * @property {"table"} kind
 * @property {string} text of corners of a board that only its owner knows
 * @property {[number, number] | null} squares of that board, where a comment says it all the same
 *
 * @typedef {object} Guess
 * @property {"guess"} kind
 * @property {number[][] | null} matrix
 * @property {boolean} packed it holds keypoints, but in a way that a page cannot read
 */

export const MAX_BYTES = 64_000_000; // bytes of a file
export const MIN_VIEW_CORNERS = 6; // of a view
const SMALL = 100; // squares that a dictionary of 50 markers has room for
const MAX_BOARD_SQUARES = 2000; // that any has
const MAX_OUTSIDE_PX = 1; // px outside of the picture that a corner may have been found

/**
 * Measurements or the camera in a file. Every file of a practice run names the simulated camera: its measurements are
 * refused.
 * @param {string} text a file's content @returns {Keypoints | Table | Guess} throws MalformedError
 */
export function read(text) {
  const found = contentOf(text);
  if (text.includes(NAME) && (found.kind !== "guess" || found.packed)) throw new MalformedError("practice");
  return found;
}

/** @param {string} text @returns {Keypoints | Table | Guess} throws MalformedError */
function contentOf(text) {
  const content = text.replace(/^\uFEFF/, "");
  const data = /^\s*\{/.test(content) ? parsed(content) : undefined;
  if (data !== undefined) return json(data);
  // mrcal's is a Python dictionary, its measurements a packed archive inside.
  if (/'(lensmodel|lens_model)'/.test(content))
    return { kind: "guess", matrix: null, packed: content.includes("'optimization_inputs'") };
  if (/^\s*\{/.test(content)) throw new MalformedError("json");
  if (isTable(content)) return { kind: "table", text: content, squares: squaresIn(content) };
  const matrix = cameraIn(content);
  if (matrix !== undefined) return { kind: "guess", matrix, packed: false };
  throw new MalformedError("unknown");
}

/** @param {unknown} data @returns {Keypoints | Guess} */
function json(data) {
  if (isPhotonVision(data)) {
    const { size, views } = photonVision(data);
    if (views.length) return { kind: "keypoints", size, views };
  }
  const matrix = cameraMatrix(data);
  if (!matrix) throw new MalformedError("unknown");
  return { kind: "guess", matrix, packed: false };
}

/** @param {string} content @returns {unknown} undefined where it is no JSON */
function parsed(content) {
  try {
    return JSON.parse(content);
  } catch (error) {
    if (!(error instanceof SyntaxError)) throw error;
    return undefined;
  }
}

/** @param {number} at @param {number} length px @returns {boolean} */
const isWithin = (at, length) => at >= -MAX_OUTSIDE_PX && at <= length - 1 + MAX_OUTSIDE_PX;

/**
 * The views as a session takes them, and their board. The service ignores which markers it has, but a board must have
 * enough of them.
 * @param {View[]} views @param {[number, number]} size of the pictures, px
 * @returns {{board: import("../lib/board.js").SentBoard, views: Numbered[]}} throws MalformedError
 */
export function prepare(views, [width, height]) {
  if (views.length === 0) throw new MalformedError("empty");
  for (const { name, image } of views) {
    const inside = image.every(([x, y]) => isWithin(x, width) && isWithin(y, height));
    if (!inside) throw new MalformedError("outside", { name, size: `${width} × ${height}` });
  }
  const { squares, views: numbered } = grid(views);
  const count = squares[0] * squares[1];
  if (count > MAX_BOARD_SQUARES) throw new MalformedError("board", { columns: squares[0] - 1, rows: squares[1] - 1 });
  return {
    board: { ...DEFAULT_BOARD, squares, dictionary: count <= SMALL ? "DICT_4X4_50" : "DICT_4X4_1000" },
    views: numbered,
  };
}
