// The board page: full screen, on another device, on paper; any ChArUco board.
import { boardFile } from "../lib/board-print.js";
import { PAPERS, fileName, papersFor, squareOn } from "../lib/papers.js";
import { el, part } from "../lib/dom.js";
import { number, onLanguage, t } from "../lib/i18n.js";
import { openPage } from "../lib/page.js";
import { liveRegion } from "../lib/live-region.js";
import words from "../messages/board.js";
import { DEFAULT_BOARD, DICTIONARIES, boardFrom, boardQuery } from "../lib/board.js";
import { reason, showProblem } from "../lib/board-problem.js";
import { drawQr } from "../lib/qr.js";
import { sheetPreview } from "./sheet-preview.js";
import { BoardScreen } from "./screen.js";

/** @typedef {typeof DEFAULT_BOARD} Board */

const LOOPBACK = /^(localhost|127\.0\.0\.1|\[::1\])$/;

const query = new URLSearchParams(location.search);
let { board, problem } = boardFrom(query);
/** @type {import("../lib/board.js").Problem | null} what is wrong with what the form says now */
let wrong = null;
openPage({ board: words });

const tell = liveRegion(part("status", HTMLElement));
const shown = {
  frame: part("frame", HTMLElement), canvas: part("board", HTMLCanvasElement), hint: part("hint", HTMLElement), code: part("code", HTMLElement),
};
const screenOf = new BoardScreen(shown, board, () => {
  tell(() => t("board.may_dim"));
});
const fields = {
  columns: part("columns", HTMLInputElement), rows: part("rows", HTMLInputElement), ratio: part("ratio", HTMLInputElement),
  dictionary: part("dictionary", HTMLSelectElement), legacy: part("legacy", HTMLInputElement),
};
const [notice, formProblem] = [part("problem", HTMLElement), part("form-problem", HTMLElement)];
/** @type {string[]} addresses of the files offered now */
let files = [];

/** Address at which this page, or another, shows this board. @param {string} page @param {Record<string, string>} [more] */
function address(page, more = {}) {
  const there = new URL(page, location.href);
  there.search = new URLSearchParams([...boardQuery(board), ...Object.entries(more)]).toString();
  there.hash = "";
  return there.href;
}

function showFields() {
  const { squares: [columns, rows], marker_ratio, dictionary, legacy } = board;
  fields.columns.value = String(columns);
  fields.rows.value = String(rows);
  fields.ratio.value = String(marker_ratio);
  fields.dictionary.value = dictionary;
  fields.legacy.checked = legacy;
}

function showPapers() {
  for (const file of files) URL.revokeObjectURL(file);
  const papers = papersFor(board);
  files = papers.map((paper) => URL.createObjectURL(boardFile(board, paper)));
  const tiles = papers.map((paper, index) => el("li", {},
    el("a", { href: files[index], download: fileName(paper) },
      sheetPreview(board, PAPERS[paper], squareOn(board, paper)),
      el("span", { class: "button" }, t("board.pdf", { paper })),
      el("span", { class: "muted" }, t("board.pdf_size", { side: squareOn(board, paper) })))));
  part("papers", HTMLElement).replaceChildren(...(tiles.length ? tiles : [el("li", {}, t("board.no_room"))]));
}

function show() {
  const { squares: [columns, rows], marker_ratio, dictionary, legacy } = board;
  screenOf.show(board);
  showPapers();
  drawQr(part("qr", SVGElement), address("./", { fill: "1" }));
  // What a phone needs to know: this board, and that its own screen does not show it.
  for (const id of ["qr-phone", "code-qr"]) drawQr(part(id, SVGElement), address("../calibrate/", { facing: "environment" }));
  for (const place of document.querySelectorAll(".only-here")) place.toggleAttribute("hidden", !LOOPBACK.test(location.hostname));
  part("description", HTMLElement).textContent = t("board.what", {
    columns, rows, dictionary, ratio: number(marker_ratio, 2), layout: t(legacy ? "board.layout_legacy" : "board.layout_new"),
  });
  for (const page of ["../calibrate/", "../photos/"]) {
    const there = address(page);
    for (const link of /** @type {NodeListOf<HTMLAnchorElement>} */ (document.querySelectorAll(`a[href*="${page.slice(2)}"]`))) link.href = there;
  }
}

function complain() {
  formProblem.textContent = wrong ? t("board.still_last", { reason: reason(wrong) }) : "";
}

function change() {
  const asked = new URLSearchParams({
    squares: `${fields.columns.value}x${fields.rows.value}`, marker_ratio: fields.ratio.value, dictionary: fields.dictionary.value,
    legacy: String(fields.legacy.checked),
  });
  const found = boardFrom(asked);
  wrong = found.problem;
  complain();
  if (found.problem) return;
  board = found.board;
  notice.hidden = true;
  history.replaceState(null, "", address("./"));
  show();
}

fields.dictionary.append(...DICTIONARIES.map((name) => new Option(name, name)));
showProblem(notice, problem);
showFields();
show();
onLanguage(() => {
  show();
  complain();
});
for (const [id, code] of /** @type {const} */ ([["full-screen", false], ["full-screen-code", true]])) {
  part(id, HTMLButtonElement).addEventListener("click", (event) => {
    event.stopPropagation(); // or this very click would close it again
    screenOf.enter({ code });
  });
}
part("form", HTMLFormElement).addEventListener("input", change);
part("form", HTMLFormElement).addEventListener("submit", (event) => event.preventDefault());
part("form", HTMLFormElement).addEventListener("reset", (event) => {
  event.preventDefault();
  board = DEFAULT_BOARD;
  showFields();
  change();
});
// Another device is sent here to show it: without a touch there is no full screen, but the window there is.
if (query.has("fill")) screenOf.fill(true);
