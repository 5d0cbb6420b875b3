// The board page: full screen, on another device, on paper; any ChArUco board.
import { number, onLanguage, t } from "../lib/i18n.js";
import { openPage } from "../lib/page.js";
import { liveRegion } from "../lib/live-region.js";
import words from "../messages/board.js";
import { DEFAULT_BOARD, DICTIONARIES, boardFrom, boardQuery } from "../lib/board.js";
import { lettering } from "./lettering.js";
import { PAPERS, boardPdf, squareSide } from "./pdf.js";
import { reason, showProblem } from "../lib/board-problem.js";
import { drawQr } from "./qr.js";
import { BoardScreen } from "./screen.js";

/** @typedef {typeof DEFAULT_BOARD} Board */

const SMALLEST = 5; // mm; a square that printers and cameras still do justice to
const LOOPBACK = /^(localhost|127\.0\.0\.1|\[::1\])$/;

/** @template {Element} E @param {string} id @param {new () => E} type @returns {E} */
function part(id, type) {
  const found = document.getElementById(id);
  if (!(found instanceof type)) throw new TypeError(`the page has no ${type.name} #${id}`);
  return found;
}

const query = new URLSearchParams(location.search);
let { board, problem } = boardFrom(query);
/** @type {import("../lib/board.js").Problem | null} what is wrong with what the form says now */
let wrong = null;
openPage({ board: words });

const tell = liveRegion(part("status", HTMLElement));
const shown = { frame: part("frame", HTMLElement), canvas: part("board", HTMLCanvasElement), hint: part("hint", HTMLElement) };
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

/** Text below a printed board. @param {number} side of a square, mm @returns {import("./pdf.js").Foot} */
function foot(side) {
  const { squares: [columns, rows], marker_ratio, dictionary, legacy } = board;
  const marker = number(side * marker_ratio, 2);
  const layout = t(legacy ? "board.layout_legacy" : "board.layout_new");
  return { bar: t("board.pdf_bar"), lines: [t("board.pdf_board", { columns, rows, side, marker, dictionary, layout }), t("board.pdf_flat")] };
}

function showPapers() {
  for (const file of files) URL.revokeObjectURL(file);
  const papers = Object.entries(PAPERS).filter(([, size]) => squareSide(board, size) >= SMALLEST);
  files = papers.map(([, size]) =>
    URL.createObjectURL(new Blob([boardPdf(board, size, foot(squareSide(board, size)), lettering)], { type: "application/pdf" })));
  part("papers", HTMLElement).replaceChildren(...papers.map(([name], index) => {
    const link = document.createElement("a");
    link.className = "button";
    link.textContent = t("board.pdf", { paper: name });
    link.href = files[index];
    link.download = `calibdb-board-${name.toLowerCase()}.pdf`;
    return link;
  }));
  const sizes = papers.map(([paper, size]) => t("board.pdf_size", { paper, side: squareSide(board, size) }));
  part("paper-sizes", HTMLElement).replaceChildren(...(sizes.length ? sizes : [t("board.no_room")]).map((text) => {
    const item = document.createElement("li");
    item.textContent = text;
    return item;
  }));
}

function show() {
  const { squares: [columns, rows], marker_ratio, dictionary, legacy } = board;
  screenOf.show(board);
  showPapers();
  drawQr(part("qr", SVGElement), address("./", { fill: "1" }));
  part("only-here", HTMLElement).hidden = !LOOPBACK.test(location.hostname);
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
part("full-screen", HTMLButtonElement).addEventListener("click", (event) => {
  event.stopPropagation(); // or this very click would close it again
  screenOf.enter();
});
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
