// Content of the first sheet: the ways to get a board in front of the camera, another screen or paper. The viewfinder
// shows the code, too, where there is no board.
import { boardQuery } from "../lib/board.js";
import { showProblem } from "../lib/board-text.js";
import { onLanguage, t } from "../lib/i18n.js";
import { WhichBoard } from "../lib/board-form.js";

/**
 * @import { Board, Problem, SentBoard } from "../lib/board.js"
 * @import { Parts } from "./parts.js"
 */

/**
 * Address that shows the board on another device.
 * @param {Board} board
 * @param {boolean} fill the whole of its window
 */
function boardAddress(board, fill) {
  const there = new URL("../board/", location.href);
  there.search = new URLSearchParams([...boardQuery(board), ...(fill ? [["fill", "1"]] : [])]).toString();
  there.hash = "";
  return there;
}

/**
 * @param {Parts} parts
 * @param {{board: SentBoard, problem: Problem | null, parameters:
 *   URLSearchParams, wanted: import("./state.js").Wanted, onBoard: (board: SentBoard) =>
 *   void, onSender: () => void}} page onBoard: called when another is chosen; onSender: when the page's sender is
 *   named
 */
export function showFirstSheet(parts, { board, problem, parameters, wanted, onBoard, onSender }) {
  showProblem(parts.problem, problem);
  const returnTo = parameters.get("return_to");
  if (returnTo !== null) {
    void import("./sender.js").then(({ showSender }) => {
      void showSender(parts, returnTo, wanted);
      onSender();
    });
  }
  const show = showWays(parts);
  show(board);
  new WhichBoard(
    board,
    (chosen) => {
      show(chosen);
      onBoard(chosen);
    },
    true,
  );
}

/**
 * Fills in what leads to the board. The QR code and the file are made by modules that are loaded after the page is
 * there.
 * @param {Parts} parts @returns {(board: Board) => void} shows another board
 */
function showWays({ boardLinks, addresses, paper, paperFile, codes }) {
  const loading = Promise.all([import("../lib/qr.js"), import("../lib/papers.js")]);
  /** @type {Board} */
  let board;
  // Who is quicker than those modules gets the file all the same.
  paper.addEventListener("click", async () => {
    const [, papers] = await loading;
    const name = paperFor(papers, board);
    const [{ boardFile }, { offerFile }] = await Promise.all([
      import("../lib/board-print.js"),
      import("../lib/files.js"),
    ]);
    if (name !== undefined) offerFile(boardFile(board, name), papers.fileName(name));
  });
  const write = async () => {
    for (const link of boardLinks) link.search = boardQuery(board).toString();
    const { host, pathname, search } = boardAddress(board, false);
    for (const place of addresses) place.textContent = host + pathname + search;
    const [{ drawQr }, papers] = await loading;
    for (const code of codes) drawQr(code, boardAddress(board, true).href);
    const name = paperFor(papers, board);
    paper.hidden = name === undefined;
    if (name !== undefined) paperFile.textContent = t("showing.paper_file", { paper: name });
  };
  onLanguage(() => void write());
  return (other) => {
    board = other;
    void write();
  };
}

/**
 * Paper that is usual here, or the first on which a board fits.
 * @param {typeof import("../lib/papers.js")} papers
 * @param {Board} board
 */
function paperFor({ papersFor, usualPaper }, board) {
  const fitting = papersFor(board);
  const usual = usualPaper(navigator.languages);
  return fitting.includes(usual) ? usual : fitting[0];
}
