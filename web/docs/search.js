// Search of the documentation: the texts are fetched when the visitor begins to type.
import { el, part } from "../lib/dom.js";
import { t } from "../lib/i18n.js";

/** @typedef {{id: number, address: string, page: string, title: string, text: string}} Section */

const MAX_RESULTS = 12;
const EXCERPT = 140; // characters
const HERE = new URL(".", import.meta.url);

/** @type {Promise<{search: (words: string) => (Section & {terms: string[]})[]}> | null} */
let index = null;

/** The index, made once of all texts. */
function load() {
  index ??= make().catch((error) => {
    index = null; // the next attempt asks again
    throw error;
  });
  return index;
}

async function make() {
  const [{ MiniSearch }, response] = await Promise.all([
    import("../vendor/minisearch/minisearch.js"),
    fetch(new URL("search.json", HERE)),
  ]);
  if (!response.ok) throw new TypeError(`search.json: ${response.status}`);
  /** @type {[string, string, string, string][]} */
  const rows = await response.json();
  const found = new MiniSearch({
    fields: ["title", "page", "text"],
    storeFields: ["address", "page", "title", "text"],
    searchOptions: { boost: { title: 4, page: 2 }, prefix: true, fuzzy: 0.15, combineWith: "AND" },
  });
  found.addAll(rows.map(([address, page, title, text], id) => ({ id, address, page, title, text })));
  return /** @type {any} */ (found);
}

/** Shows the form, which is useless without a script, and handles it. */
export function offerSearch() {
  const form = part("search", HTMLFormElement);
  const words = part("words", HTMLInputElement);
  const results = part("results", HTMLUListElement);
  form.hidden = false;
  focusBySlash(words);
  words.addEventListener("focus", () => void load().catch(() => {}), { once: true });
  words.addEventListener("input", () => void show());
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const first = results.querySelector("a");
    if (first) location.assign(first.href);
  });
  form.addEventListener("keydown", (event) => {
    if (event.key === "Escape") {
      words.value = "";
      words.focus();
      void show();
    }
    const links = [...results.querySelectorAll("a")];
    const at = links.indexOf(/** @type {HTMLAnchorElement} */ (document.activeElement));
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (!step || links.length === 0) return;
    event.preventDefault();
    const next = at + step;
    if (next < 0) words.focus();
    else links[Math.min(next, links.length - 1)].focus();
  });
}

/** Makes the key / focus the search, except in a field. @param {HTMLInputElement} words */
function focusBySlash(words) {
  document.addEventListener("keydown", (event) => {
    const isTyping = event.target instanceof Element && event.target.closest("input, select, textarea");
    if (event.key !== "/" || event.ctrlKey || event.metaKey || event.altKey || isTyping) return;
    event.preventDefault();
    words.focus();
  });
}

async function show() {
  const asked = part("words", HTMLInputElement).value.trim();
  const results = part("results", HTMLUListElement);
  const status = part("found", HTMLElement);
  if (!asked) {
    results.hidden = true;
    status.textContent = "";
    return;
  }
  /** @type {Node[]} */
  let items;
  try {
    const all = (await load()).search(asked);
    if (part("words", HTMLInputElement).value.trim() !== asked) return; // the visitor has typed more meanwhile
    status.textContent = all.length ? t("docs.found", { count: all.length }) : t("docs.none");
    items = all.slice(0, MAX_RESULTS).map(item);
  } catch (error) {
    if (!(error instanceof TypeError)) throw error; // how fetch and import fail without a network
    status.textContent = t("docs.no_search");
    items = [];
  }
  results.replaceChildren(...(items.length ? items : [el("li", { class: "muted" }, status.textContent)]));
  results.hidden = false;
}

/** @param {Section & {terms: string[]}} section */
function item({ address, page, title, text, terms }) {
  const name = page === title ? title : `${page} › ${title}`;
  const places = terms.map((term) => text.toLowerCase().indexOf(term)).filter((place) => place >= 0);
  const start = Math.max(0, Math.min(...(places.length ? places : [0])) - EXCERPT / 3);
  const end = start + EXCERPT;
  const excerpt = `${start > 0 ? "…" : ""}${text.slice(start, end)}${end < text.length ? "…" : ""}`;
  return el(
    "li",
    {},
    el(
      "a",
      { href: new URL(address, HERE).href },
      el("strong", {}, name),
      " ",
      el("span", {}, ...marked(excerpt, terms)),
    ),
  );
}

/** Parts of a text, with marks around words. @param {string} text @param {string[]} terms */
function marked(text, terms) {
  const words = terms.map((term) => term.replace(/[.*+?^${}()|[\]\\]/g, "\\$&"));
  const parts = text.split(new RegExp(`(${words.join("|")})`, "i"));
  return parts.map((part, index) => (index % 2 ? el("mark", {}, part) : part));
}
