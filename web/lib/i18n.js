// Messages of the pages, in the visitor's language.
//
//     import { t, translate } from "../lib/i18n.js";
//     t("board.full_screen"); t("board.views", { count: 3 });
//
// `messages/de/board.json` is the German catalog "board": key → text, with the same keys in each language. A built
// page contains the texts that it may show in its own language, as JSON (infra/web_build/messages.mjs); another
// language comes from the page in that language. A message has its values in braces, "{count} views"; one that
// depends on a number is an object of plural forms, chosen by the value `count`. In pages: data-t is the element's
// text, data-t-label its aria-label, data-t-title its title, data-t-alt that of a picture. Where the element has
// children of its own, "<0>…</0>" in the text is the first of them, "<1>…</1>" the second.
//
// Each page is there in every language, "/board/", "/de/board/", with its texts already in place
// (infra/web_build/site.mjs).
// A change of language writes the texts again where they stand, so that nothing under way is lost, and changes the
// address.

/**
 * @typedef {"en" | "de" | "uk"} Language
 * @typedef {string | Partial<Record<Intl.LDMLPluralRule, string>>} Text
 */

/** The languages by their own names. @type {Record<Language, string>} */
export const LANGUAGES = { en: "English", de: "Deutsch", uk: "Українська" };
const CHOICE = { en: "Language", de: "Sprache", uk: "Мова" };
const LANGUAGE_KEY = "calibdb.language";
const ROOT = new URL("../", import.meta.url).pathname; // of the site
const PREFIX = /^(?:(de|uk)\/)?/; // of an address below it
const UNIT = /(\d) (?=(?:px|mm|%|s)(?![\p{L}\d]))/gu; // no line ends between a number and its unit

/** "catalog.key" → text. @type {Record<Language, Record<string, Text>>} */
const messages = { en: {}, de: {}, uk: {} };
/** @type {Set<(language: Language) => void>} */
const listeners = new Set();
/** @type {WeakMap<Element, Element[]>} an element's own children, in the order of the page */
const children = new WeakMap();
/** @type {Language | null} */
let current = null;

/** @param {Language} spoken @param {Record<string, Text>} texts by "catalog.key" */
export function addMessages(spoken, texts) {
  Object.assign(messages[spoken], texts);
}

/** Adds the texts that a page contains. @param {Document | undefined} page @param {Language} spoken */
function addFrom(page, spoken) {
  const texts = page?.getElementById?.("messages")?.textContent;
  if (texts) addMessages(spoken, JSON.parse(texts));
}

/** The language spoken now. @returns {Language} */
export function language() {
  // Pages are served in their language; language.js has redirected visitors who prefer another one.
  current ??= choose(
    languageInQuery(),
    globalThis.document?.documentElement?.lang || keep(),
    globalThis.navigator?.languages ?? [],
  );
  return current;
}

/**
 * The first supported language of: the address's, the one chosen before, the browser's; else English.
 * @param {string | null} wanted @param {string | null} kept @param {readonly string[]} preferred BCP 47, best first
 * @returns {Language}
 */
export function choose(wanted, kept, preferred) {
  const known = [wanted, kept, ...preferred]
    .map((tag) => tag?.toLowerCase().split("-")[0] ?? "")
    .find((tag) => tag in LANGUAGES);
  return /** @type {Language} */ (known ?? "en");
}

/** Speaks another language from now on, on this page and the next ones. @param {Language} chosen */
export function setLanguage(chosen) {
  current = chosen;
  keep(chosen);
  if (globalThis.location) history.replaceState(history.state, "", inLanguage(location.href, chosen));
  if (globalThis.document) translate(document.documentElement);
  for (const listener of listeners) listener(chosen);
}

/** @param {(language: Language) => void} listener called after each change @returns {() => void} ends it */
export function onLanguage(listener) {
  listeners.add(listener);
  return () => listeners.delete(listener);
}

/**
 * A text in the language spoken now.
 * @param {string} key "catalog.key" @param {Record<string, string | number>} [values] for what is in braces
 * @returns {string} the key itself where there is no such text
 */
export function t(key, values = {}) {
  return say(key, values, language());
}

/** @param {string} key @param {Record<string, string | number>} values @param {Language} spoken */
export function say(key, values, spoken) {
  const text = messages[spoken][key];
  if (text === undefined) return key;
  const form =
    typeof text === "string"
      ? text
      : (text[new Intl.PluralRules(spoken).select(Number(values.count))] ?? text.other ?? key);
  const whole = form.replace(/\{(\w+)\}/g, (braces, name) => (name in values ? String(values[name]) : braces));
  return whole.replace(UNIT, "$1\u00a0");
}

/** True if there is such a text. @param {string} key */
export function hasMessage(key) {
  return key in messages[language()];
}

/**
 * A measured number as it is written in the language spoken now, not grouped.
 * @param {number} value
 * @param {number} digits after the point
 */
export function number(value, digits) {
  const rounded = Number(value.toFixed(digits)) || 0; // nought has no sign
  const written = rounded.toLocaleString(language(), {
    minimumFractionDigits: digits,
    maximumFractionDigits: digits,
    useGrouping: false,
  });
  return written.replace("-", "−");
}

/** A day as it is written. @param {number} time unix seconds */
export const dateText = (time) =>
  new Intl.DateTimeFormat(language(), { dateStyle: "medium" }).format(new Date(time * 1000));

/** A size as it is written, on one line. @param {readonly number[]} size */
export const formatSize = (size) => size.join("\u00a0×\u00a0");

/** "4 views · ChArUco 9 × 6": no line begins with a dot. @param {string[]} facts */
export const joinFacts = (facts) => facts.join("\u00a0· ");

/** As many digits as a measured error is worth: two. @param {number} value */
export function rough(value) {
  const digits = value > 0 ? Math.min(4, Math.max(0, 1 - Math.floor(Math.log10(value)))) : 1;
  return number(value, digits);
}

/** Puts the texts into all marked elements in and below one; sets the page's language too. @param {Element} root */
export function translate(root) {
  root.ownerDocument.documentElement.lang = language();
  for (const element of [
    root,
    ...root.querySelectorAll("[data-t], [data-t-label], [data-t-title], [data-t-alt], [data-t-content]"),
  ]) {
    const { t: text, tLabel, tTitle, tAlt, tContent } = /** @type {HTMLElement} */ (element).dataset ?? {};
    if (text) write(element, t(text));
    if (tLabel) element.setAttribute("aria-label", t(tLabel));
    if (tTitle) element.setAttribute("title", t(tTitle));
    if (tAlt) element.setAttribute("alt", t(tAlt));
    if (tContent) element.setAttribute("content", t(tContent));
  }
}

/** Makes a select the place where the language is chosen. @param {HTMLSelectElement} select */
export function offerLanguages(select) {
  if (!select.options.length) {
    select.replaceChildren(
      ...Object.entries(LANGUAGES).map(([code, name]) => {
        const option = new Option(name, code);
        option.lang = code;
        return option;
      }),
    );
  }
  const show = () => {
    select.value = language();
    select.setAttribute("aria-label", CHOICE[language()]);
  };
  select.dataset.inPlace = "";
  select.addEventListener("change", async () => {
    const chosen = /** @type {Language} */ (select.value);
    try {
      await loadMessages(chosen);
    } catch (error) {
      if (!(error instanceof TypeError)) throw error;
      return show(); // without a network the page stays in its language
    }
    if (select.value === chosen) setLanguage(chosen);
  });
  onLanguage(show);
  show();
}

/** Loads the texts of this page in another language. @param {Language} wanted */
async function loadMessages(wanted) {
  if (Object.keys(messages[wanted]).length) return;
  const { origin, pathname } = inLanguage(location.href, wanted);
  const response = await fetch(origin + pathname);
  if (!response.ok) throw new TypeError(`the page in this language: ${response.status}`);
  addFrom(new DOMParser().parseFromString(await response.text(), "text/html"), wanted);
}

/** A text around the element's own children, which keep what they do. @param {Element} element @param {string} text */
function write(element, text) {
  const own = children.get(element) ?? [...element.children];
  children.set(element, own);
  const parts = text.split(/<(\d)>(.*?)<\/\1>/);
  if (parts.length === 1 && own.length === 0) {
    // Written only where it changed: a live region speaks on every write.
    if (element.textContent !== text) element.textContent = text;
    return;
  }
  /** @type {(string | Element)[]} */
  const content = [];
  for (let at = 0; at < parts.length; at += 3) {
    content.push(parts[at]);
    const child = own[Number(parts[at + 1])];
    if (!child) continue;
    child.textContent = parts[at + 2];
    content.push(child);
  }
  element.replaceChildren(...content);
}

/** The address of a page in the language spoken now. @param {string} page from the site's root, "board/?squares=8x5" */
export function pageUrl(page) {
  return inLanguage(new URL(ROOT + page, globalThis.location?.href ?? import.meta.url).href, language());
}

/**
 * The address of the same page in another language.
 * @param {string} address
 * @param {Language} language
 * @returns {URL}
 */
function inLanguage(address, language) {
  const there = new URL(address);
  if (!there.pathname.startsWith(ROOT)) return there;
  there.pathname = ROOT + there.pathname.slice(ROOT.length).replace(PREFIX, language === "en" ? "" : `${language}/`);
  there.searchParams.delete("lang");
  // An English address leads to another language whose reader prefers that, unless English was chosen.
  if (language === "en" && keep() !== "en" && preferred() !== "en") there.searchParams.set("lang", "en");
  return there;
}

/** The language that the address asks for in its query. */
function languageInQuery() {
  return globalThis.location ? new URLSearchParams(location.search).get("lang") : null;
}

/** The language that the browser prefers. */
const preferred = () => choose(null, null, globalThis.navigator?.languages ?? []);

/** Stores the choice, if given. Returns the previous one. @param {Language} [chosen] @returns {string | null} */
function keep(chosen) {
  try {
    const kept = globalThis.localStorage?.getItem(LANGUAGE_KEY) ?? null;
    if (chosen) globalThis.localStorage?.setItem(LANGUAGE_KEY, chosen);
    return kept;
  } catch (error) {
    // A browser that blocks storage throws on access.
    if (!(error instanceof DOMException)) throw error;
    return null;
  }
}

addFrom(globalThis.document, language());
