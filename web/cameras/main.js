// Page of the database: /cameras/ searches, /cameras/?key=… shows one camera.
import { ApiError } from "../lib/api.js";
import { el, part, liveRegion } from "../lib/dom.js";
import { newestFigures } from "../lib/dumps.js";
import { explain } from "../lib/faults.js";
import { joinFacts, language, onLanguage, t } from "../lib/i18n.js";
import { openPage } from "../lib/page.js";
import { splitLabel } from "../lib/camera-name.js";
import { cameraView } from "./camera.js";
import { cameraRow, sortedBy } from "./list.js";
import { camera, search } from "./source.js";

/**
 * @import { Column } from "./list.js"
 * @import { CameraPage, Found } from "./source.js"
 */

const TYPING_PAUSE_MS = 250; // ms after the last key
openPage();
const [searching, status, list, one] = ["searching", "status", "found", "one"].map((id) => part(id, HTMLElement));
const [input, state, more] = [
  part("query", HTMLInputElement),
  part("show", HTMLSelectElement),
  part("more", HTMLButtonElement),
];
const [tell, offers] = [liveRegion(status), liveRegion(part("first", HTMLElement))];
/** @type {Found[]} */
let found = [];
/** @type {string | null} */
let next = null;
/** @type {{column: Column, isDescending: boolean} | null} null: as the service lists them */
let order = null;
/** @type {CameraPage | null} */
let shown = null;
/** The current request; an answer to anything else comes too late. */
let asked = 0;

function showList() {
  const rows = order ? sortedBy(found, order.column) : found;
  if (order?.isDescending) rows.reverse();
  list.replaceChildren(...rows.map(cameraRow));
  part("table", HTMLElement).hidden = found.length === 0;
  list.removeAttribute("aria-busy");
  more.hidden = next === null;
}

/** Sorts by a column; names rise first, amounts fall first. @param {HTMLButtonElement} button */
function sortBy(button) {
  const column = /** @type {Column} */ (button.dataset.column);
  order = { column, isDescending: order?.column === column ? !order.isDescending : column !== "name" };
  for (const head of part("table", HTMLElement).querySelectorAll("th[aria-sort]")) head.removeAttribute("aria-sort");
  button.parentElement?.setAttribute("aria-sort", order.isDescending ? "descending" : "ascending");
  showList();
}

/** Keeps the search in the address, so that reloads, history and shared links have it. */
function keepQuery() {
  const there = new URL(location.href);
  for (const [name, value] of [
    ["query", input.value.trim()],
    ["show", state.value],
  ]) {
    if (value) there.searchParams.set(name, value);
    else there.searchParams.delete(name);
  }
  if (there.href !== location.href) history.replaceState(history.state, "", there);
}

/** Next steps where nothing was found. */
function offer() {
  const nothing = found.length === 0 && next === null;
  const link = (/** @type {string} */ page, /** @type {string} */ key, attributes = {}) =>
    el("a", { class: "button", href: `../${page}/`, ...attributes }, t(key));
  offers(() =>
    nothing
      ? [
          link("calibrate", "cameras.calibrate_yours", { class: "button primary", id: "calibrate-first" }),
          link("photos", "cameras.from_photos"),
          link("import", "cameras.from_file"),
        ]
      : [],
  );
}

/** @param {{further?: boolean}} [options] */
async function look({ further = false } = {}) {
  const own = ++asked;
  const wait = (/** @type {object | null} */ retry) =>
    own === asked && tell(() => t(retry ? "faults.retry" : "cameras.searching"));
  if (!further) {
    keepQuery();
    if (found.length === 0) wait(null);
  }
  try {
    const answer = await search(
      input.value.trim(),
      /** @type {"" | "ready" | "open"} */ (state.value),
      further ? next : null,
      wait,
    );
    if (own !== asked) return;
    found = further ? [...found, ...answer.cameras] : answer.cameras;
    next = answer.next;
    // Where many names begin with the first word, a page of answers may hold none of them.
    if (answer.cameras.length === 0 && next !== null) return await look({ further: true });
    showList();
    offer();
    const named = input.value.trim() !== "" || state.value !== "";
    tell(() => (found.length ? "" : t(named ? "cameras.none" : "cameras.empty")));
  } catch (error) {
    if (own === asked) tell(() => explain(error));
  }
}

/** The database in figures, as the last dump counted it. */
async function showFigures() {
  const figures = await newestFigures();
  if (!figures) return;
  const count = (/** @type {number} */ value) => value.toLocaleString(language());
  const { cameras, known: ready, calibrations } = figures;
  liveRegion(part("figures", HTMLElement))(() =>
    joinFacts([
      t("cameras.total", { count: cameras, number: count(cameras) }),
      t("cameras.total_ready", { count: ready, number: count(ready) }),
      t("cameras.total_calibrations", { count: calibrations, number: count(calibrations) }),
    ]),
  );
}

/** Reason why there is nothing to show, and the way on. */
function leadOn() {
  const ways = el("div", { class: "actions" });
  liveRegion(ways)(() => [
    el("a", { class: "button primary", href: "./" }, t("cameras.search_all")),
    el("a", { class: "button", href: "../calibrate/" }, t("cameras.calibrate_yours")),
  ]);
  part("waiting", HTMLElement).append(ways);
}

/** @param {string} key */
async function show(key) {
  searching.hidden = true;
  const waiting = part("waiting", HTMLElement);
  waiting.hidden = false;
  const say = liveRegion(part("waiting-text", HTMLElement));
  const wait = (/** @type {object | null} */ retry) => say(() => t(retry ? "faults.retry" : "cameras.loading"));
  wait(null);
  try {
    shown = await camera(key, wait);
    document.title = `${splitLabel(shown.camera).name} · calibDB`;
    waiting.hidden = true;
    one.replaceChildren(cameraView(shown, explain));
  } catch (error) {
    const missing = error instanceof ApiError && error.status === 404;
    say(() => (missing ? t("cameras.missing") : explain(error)));
    leadOn();
  }
}

/** @type {ReturnType<typeof setTimeout> | undefined} */
let timer;
input.addEventListener("input", () => {
  clearTimeout(timer);
  timer = setTimeout(() => void look(), TYPING_PAUSE_MS);
});
part("search", HTMLFormElement).addEventListener("submit", (event) => {
  event.preventDefault();
  clearTimeout(timer);
  void look();
});
state.addEventListener("change", () => void look());
for (const button of part("table", HTMLElement).querySelectorAll("button")) {
  button.addEventListener("click", () => sortBy(button));
}
more.addEventListener("click", () => look({ further: true }));
onLanguage(() => {
  if (shown) return one.replaceChildren(cameraView(shown, explain));
  showList();
});
const parameters = new URLSearchParams(location.search);
const key = parameters.get("key");
if (key) void show(key);
else {
  input.value = parameters.get("query") ?? "";
  state.value = ["ready", "open"].find((each) => each === parameters.get("show")) ?? "";
  void showFigures();
  void look();
}
