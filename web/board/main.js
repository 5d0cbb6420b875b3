// The board page: full screen, on another device, on paper; boards of any kind.
import { boardFile } from "../lib/board-print.js";
import { PAPERS, fileName, papersFor, squareOn, usualPaper } from "../lib/papers.js";
import { el, liveRegion, make, part } from "../lib/dom.js";
import { onLanguage, t } from "../lib/i18n.js";
import { openPage } from "../lib/page.js";
import { DEFAULT_BOARD, boardFrom, boardQuery, circlesCommand, isCircles, sizeOf } from "../lib/board.js";
import { BoardForm } from "../lib/board-form.js";
import { boardWords, showProblem } from "../lib/board-text.js";
import { drawQr } from "../lib/qr.js";
import { BoardScreen } from "./screen.js";
import { blackRectangles } from "../lib/board-drawing.js";

/** @typedef {typeof DEFAULT_BOARD} Board */

const LOOPBACK = /^(localhost|127\.0\.0\.1|\[::1\])$/;

const query = new URLSearchParams(location.search);
let { board, problem } = boardFrom(query, { circles: true });
openPage();

const tell = liveRegion(part("status", HTMLElement));
const shown = {
  frame: part("frame", HTMLElement),
  canvas: part("board", HTMLCanvasElement),
  hint: part("hint", HTMLElement),
  code: part("code", HTMLElement),
};
const screenOf = new BoardScreen(shown, board, () => {
  tell(() => t("board.may_dim"));
});
const notice = part("problem", HTMLElement);
/** @type {string[]} addresses of the files offered now */
let files = [];

/**
 * Address at which this page, or another, shows this board.
 * @param {string} page
 * @param {Record<string, string>} [more]
 */
function address(page, more = {}) {
  const there = new URL(page, location.href);
  there.search = new URLSearchParams([...boardQuery(board), ...Object.entries(more)]).toString();
  there.hash = "";
  return there.href;
}

function showPapers() {
  for (const file of files) URL.revokeObjectURL(file);
  const usual = usualPaper(navigator.languages);
  const papers = papersFor(board).sort((a, b) => Number(b === usual) - Number(a === usual));
  files = papers.map((paper) => URL.createObjectURL(boardFile(board, paper)));
  const tiles = papers.map((paper, index) =>
    el(
      "li",
      {},
      el(
        "a",
        { href: files[index], download: fileName(paper) },
        sheetPreview(board, PAPERS[paper], squareOn(board, paper)),
        el("span", { class: "button" }, t("board.pdf", { paper })),
        el("span", { class: "muted" }, t("board.pdf_size", { side: squareOn(board, paper) })),
      ),
    ),
  );
  part("papers", HTMLElement).replaceChildren(tiles[0] ?? el("li", {}, t("board.no_room")));
  part("other-papers", HTMLElement).replaceChildren(...tiles.slice(1));
  part("more-papers", HTMLElement).hidden = tiles.length < 2;
}

function show() {
  screenOf.show(board);
  showPapers();
  drawQr(part("qr", SVGElement), address("./", { fill: "1" }));
  // What a phone needs to know: this board, and that this screen shows it, not its own.
  for (const id of ["qr-phone", "code-qr"])
    drawQr(part(id, SVGElement), address("../calibrate/", { facing: "environment", surface: "screen" }));
  part("only-here", HTMLElement).hidden = !LOOPBACK.test(location.hostname);
  part("description", HTMLElement).textContent = boardWords(board);
  // Pages do not detect circles: then the command takes the place of their links.
  const onlyCommand = isCircles(board);
  for (const place of document.querySelectorAll(".detected")) place.toggleAttribute("hidden", onlyCommand);
  for (const place of document.querySelectorAll(".command")) place.toggleAttribute("hidden", !onlyCommand);
  for (const place of document.querySelectorAll(".command code")) place.textContent = circlesCommand(board);
  for (const page of ["../calibrate/", "../photos/"]) {
    const there = address(page);
    for (const link of /** @type {NodeListOf<HTMLAnchorElement>} */ (
      document.querySelectorAll(`a[href*="${page.slice(2)}"]`)
    ))
      link.href = there;
  }
}

/** @param {Board} chosen */
function change(chosen) {
  board = chosen;
  notice.hidden = true;
  history.replaceState(null, "", address("./"));
  show();
}

const form = new BoardForm(board, {
  onChoice: change,
  event: "input",
  circles: true,
  problemText: (reason) => t("board.still_last", { reason }),
});
showProblem(notice, problem);
show();
onLanguage(show);
for (const [id, code] of /** @type {const} */ ([
  ["full-screen", false],
  ["full-screen-code", true],
])) {
  part(id, HTMLButtonElement).addEventListener("click", (event) => {
    event.stopPropagation(); // or this very click would close it again
    screenOf.enter({ code });
  });
}
part("reset", HTMLButtonElement).addEventListener("click", () => {
  form.show(DEFAULT_BOARD);
  change(DEFAULT_BOARD);
});
// Another device is sent here to show it: without a touch there is no full screen, but the window there is.
if (query.has("fill")) screenOf.fill(true);

/**
 * A printed sheet in small: the board as it lies on the paper.
 * @param {import("../lib/board.js").Board} board
 * @param {[number, number]} paper mm, landscape
 * @param {number} side of a square, mm
 * @returns {SVGElement}
 */
function sheetPreview(board, [width, height], side) {
  const [columns, rows] = sizeOf(board);
  const [left, top] = [(width - columns * side) / 2, (height - rows * side) / 2];
  const path = blackRectangles(board)
    .map(([x, y, w, h]) => `M${left + x * side} ${top + y * side}h${w * side}v${h * side}h${-w * side}z`)
    .join("");
  return make("svg", { viewBox: `0 0 ${width} ${height}`, "aria-hidden": "true" }, [
    make("rect", { class: "sheet-paper", width, height }),
    make("path", { d: path }),
  ]);
}
