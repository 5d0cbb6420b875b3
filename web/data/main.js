// The database in figures, and its weekly dump: read from two objects that the dump leaves, so that the page costs no
// function.
import { el, part } from "../lib/dom.js";
import { DUMPS, fetchObject } from "../lib/dumps.js";
import { language, onLanguage, t } from "../lib/i18n.js";
import { openPage } from "../lib/page.js";
import { chart } from "./chart.js";

/** @import { Snapshot } from "../lib/dumps.js" */

/**
 * @typedef {object} Statistics
 * @property {number} created s since 1970
 * @property {Snapshot[]} history oldest first
 * @property {{key: string | null, camera: string, asked: number, calibrations: number}[]} wanted most asked for first
 * @property {{name: string, size: number} | null} [bundle]
 *
 * @typedef {object} Dump
 * @property {number} created s since 1970
 * @property {{calibrations: number, votes: number, cameras: number, contributors: number}} counts
 * @property {{name: string, count: number, size: number, sha256: string}[]} files
 */

const FIGURES = /** @type {const} */ (["cameras", "known", "calibrations", "contributors"]);

openPage();
/** @type {Statistics | null} */
let statistics = null;
/** @type {Dump | null} */
let dump = null;
let status = "data.loading";

const count = (/** @type {number} */ value) => value.toLocaleString(language());
const day = (/** @type {number} */ seconds) =>
  new Date(1000 * seconds).toLocaleDateString(language(), { dateStyle: "long" });

/** An amount of bytes as people read it. @param {number} value */
function bytes(value) {
  const [unit, factor] = value >= 1e9 ? ["gigabyte", 1e9] : value >= 1e6 ? ["megabyte", 1e6] : ["kilobyte", 1e3];
  return (value / Number(factor)).toLocaleString(language(), {
    style: "unit",
    unit: String(unit),
    maximumSignificantDigits: 3,
  });
}

/** @param {string} name @param {boolean} there */
const reveal = (name, there) => void (part(name, HTMLElement).hidden = !there);

function show() {
  part("status", HTMLElement).textContent = t(status, { date: statistics ? day(statistics.created) : "" });
  for (const name of ["figures", "coverage"]) reveal(name, statistics !== null || status === "data.loading");
  showStatistics();
  showDump();
}

function showStatistics() {
  if (!statistics) return;
  const { history, wanted, bundle } = statistics;
  const newest = history[history.length - 1];
  for (const name of FIGURES) part(name, HTMLElement).textContent = count(newest[name]);
  part("chart", HTMLElement).replaceChildren(
    ...(history.length > 1 ? [chart(history, t("data.chart"), [t("data.cameras"), t("data.known")])] : []),
  );
  const head = el(
    "tr",
    {},
    ...[t("data.date"), ...FIGURES.map((name) => t(`data.${name}`))].map((text) => el("th", { scope: "col" }, text)),
  );
  const rows = [...history]
    .reverse()
    .map((snapshot) =>
      el(
        "tr",
        {},
        el("th", { scope: "row" }, snapshot.date),
        ...FIGURES.map((name) => el("td", {}, count(snapshot[name]))),
      ),
    );
  part("history", HTMLElement).replaceChildren(el("thead", {}, head), el("tbody", {}, ...rows));
  part("wanted-rows", HTMLElement).replaceChildren(
    ...wanted.map(({ key, camera, asked, calibrations }) =>
      el(
        "tr",
        {},
        el(
          "th",
          { scope: "row" },
          key ? el("a", { href: `../cameras/?key=${encodeURIComponent(key)}` }, camera) : camera,
        ),
        el("td", { "data-label": t("data.asked") }, count(asked)),
        el("td", { "data-label": t("data.so_far") }, count(calibrations)),
      ),
    ),
  );
  reveal("chart-table", true);
  reveal("wanted-table", wanted.length > 0);
  reveal("nothing-wanted", wanted.length === 0);
  reveal("bundle-line", Boolean(bundle));
}

function showDump() {
  if (!dump) return;
  const { counts, files, created } = dump;
  const values = Object.fromEntries(Object.entries(counts).map(([name, value]) => [name, count(value)]));
  part("dump-about", HTMLElement).textContent = t("data.about", { ...values, date: day(created) });
  part("files", HTMLElement).replaceChildren(
    ...files.map((file) =>
      el(
        "tr",
        {},
        el("th", { scope: "row" }, el("a", { href: new URL(file.name, DUMPS).href, download: "" }, file.name)),
        el("td", {}, count(file.count)),
        el("td", {}, bytes(file.size)),
        el("td", { class: "words" }, el("code", { class: "digest" }, file.sha256)),
      ),
    ),
  );
  reveal("dump", true);
  reveal("no-dump", false);
}

show();
onLanguage(show);
try {
  /** @type {Statistics | null} */
  const figures = await fetchObject("statistics.json");
  statistics = figures?.history.length ? figures : null;
  if (statistics) dump = await fetchObject("latest.json");
  status = statistics ? "data.as_of" : "data.none_yet";
  show();
} finally {
  part("content", HTMLElement).classList.remove("waiting");
}
