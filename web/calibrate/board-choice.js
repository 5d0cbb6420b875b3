// Choice of another board than the one expected: the one before the camera, or one described on the first sheet.
import { boardQuery } from "../lib/board.js";
import { plainNotice, viewCount } from "./state.js";

/** @typedef {import("../lib/board.js").SentBoard} Board */

// in addresses
const BOARD_NAMES = ["kind", "squares", "marker_ratio", "dictionary", "legacy", "inverted", "tag_spacing", "surface"];

/** Writes a board into the parameters of an address. @param {URLSearchParams} parameters @param {Board} board */
export function nameBoard(parameters, board) {
  for (const name of BOARD_NAMES) parameters.delete(name);
  for (const [name, value] of boardQuery(board)) parameters.set(name, value);
}

/**
 * Takes the suggested board for the capture from now on, turns mirrored pictures back, and says so.
 * @param {Pick<import("./request-queue.js").Page, "state" | "dispatch">} page
 * @param {URLSearchParams} parameters of its address
 * @returns {{board: Board, notice: import("./state.js").Notice} | null} null: none is suggested any more, or a view was
 *   taken meanwhile
 */
export function takeSuggestion({ state, dispatch }, parameters) {
  const {
    detector: { suggestion },
    wanted: { flipped },
  } = state();
  if (!suggestion || viewCount(state()) > 0) return null;
  const { board, mirrored } = suggestion;
  nameBoard(parameters, board);
  const [columns, rows] = board.squares;
  if (!mirrored) return { board, notice: plainNotice("capture.board_taken", { columns, rows }) };
  dispatch({ type: "flip" });
  if (flipped) parameters.delete("flipped");
  else parameters.set("flipped", "true");
  return { board, notice: plainNotice("capture.flipped", { columns, rows }) };
}
