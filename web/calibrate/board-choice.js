// Recognition of a board that is not the one expected, so that a visitor can go on with it.
import { isTelling, recognise } from "../lib/board-recognition.js";
import { boardQuery } from "../lib/board.js";
import { grab } from "../lib/detector.js";
import { nextFrame } from "../lib/frames.js";
import { plainNotice, viewCount } from "./state.js";

/** @typedef {import("../lib/board.js").SentBoard} Board */

const MAX_PICTURES = 3; // that are looked at: one may be blurred
const BOARD_NAMES = ["kind", "squares", "marker_ratio", "dictionary", "legacy", "inverted", "tag_spacing"]; // in addresses

/**
 * The board before the camera.
 * @param {import("../lib/detector.js").Detector} detector @param {HTMLVideoElement} video
 * @returns {Promise<Board | null>} null: none is recognised
 */
async function lookAtBoard(detector, video) {
  /** @type {import("../lib/board-recognition.js").Sighting[]} */
  const sightings = [];
  while (sightings.length < MAX_PICTURES && !sightings.some(isTelling)) {
    await nextFrame(video);
    sightings.push(await detector.sight(await grab(video), { inverted: true }));
  }
  return recognise(sightings)?.board ?? null;
}

/** Writes a board into the parameters of an address. @param {URLSearchParams} parameters @param {Board} board */
function nameBoard(parameters, board) {
  for (const name of BOARD_NAMES) parameters.delete(name);
  for (const [name, value] of boardQuery(board)) parameters.set(name, value);
}

/**
 * Takes the board before the camera for the capture from now on, and says so.
 * @param {import("./request-queue.js").Page} page @param {URLSearchParams} parameters of its address
 * @returns {Promise<{board: Board, notice: import("./state.js").Notice} | null>} null: none is recognised, or a view was taken meanwhile
 */
export async function takeBoard({ parts, state, dispatch, openDetector }, parameters) {
  const tell = (/** @type {string} */ key) => dispatch({ type: "notice", notice: plainNotice(key), time: performance.now() });
  tell("capture.looking_at_board");
  // A detector that fails meanwhile is the capture's to report.
  const board = await lookAtBoard(await openDetector(), parts.video).catch(() => null);
  if (state().phase !== "capturing" || viewCount(state()) > 0) return null;
  if (!board) {
    tell("capture.board_not_recognised");
    return null;
  }
  nameBoard(parameters, board);
  const [columns, rows] = board.squares;
  return { board, notice: plainNotice("capture.board_taken", { columns, rows }) };
}
