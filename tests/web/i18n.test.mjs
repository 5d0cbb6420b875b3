import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { test } from "node:test";
import { runInNewContext } from "node:vm";
import { parseHTML } from "linkedom";
import { mentionedKeys } from "../../infra/web_build/messages.mjs";
import { LANGUAGES, addMessages, choose, hasMessage, number, rough, say, setLanguage } from "../../web/lib/i18n.js";
import { messages } from "./messages.mjs";

const WEB = new URL("../../web/", import.meta.url);
const files = (folder, kind) =>
  readdirSync(new URL(folder, WEB), { recursive: true })
    .map((name) => name.replaceAll("\\", "/"))
    .filter((name) => name.endsWith(kind) && !name.startsWith("vendor/"));
const sources = [...files("", ".js"), ...files("", ".html")]
  .filter((name) => name !== "lib/i18n.js")
  .map((name) => readFileSync(new URL(name, WEB), "utf8"))
  .concat(
    readdirSync(new URL("../../infra/web_build/", import.meta.url), { recursive: true })
      .map(String)
      .filter((name) => /\.mjs$/.test(name))
      .map((name) => readFileSync(new URL(`../../infra/web_build/${name}`, import.meta.url), "utf8")),
  );
const texts = (text) => (typeof text === "string" ? [text] : Object.values(text));
/** Parameters of a text: values in braces, children of the element. */
const needs = (text) => [...new Set(texts(text).flatMap((form) => form.match(/\{\w+\}|<\d>/g) ?? []))].sort();

test("every text is there in every language, with the same values", () => {
  for (const language of Object.keys(LANGUAGES)) {
    assert.deepEqual(Object.keys(messages[language]).sort(), Object.keys(messages.en).sort(), language);
    for (const [key, text] of Object.entries(messages[language])) {
      assert.deepEqual(needs(text), needs(messages.en[key]), `${language} ${key}`);
      for (const form of texts(text)) assert.ok(form.trim() === form && form !== "", `${language} ${key}`);
    }
  }
});

test("plural forms are those that the language has", () => {
  for (const language of Object.keys(LANGUAGES)) {
    const forms = new Intl.PluralRules(language).resolvedOptions().pluralCategories;
    for (const [key, text] of Object.entries(messages[language])) {
      if (typeof text !== "string") assert.deepEqual(Object.keys(text).sort(), [...forms].sort(), `${language} ${key}`);
    }
  }
});

test("every text is used, and every text used is there", () => {
  const all = Object.keys(messages.en);
  const mentioned = new Set(mentionedKeys(sources, all));
  assert.deepEqual(
    all.filter((key) => !mentioned.has(key)),
    [],
  );
  const keys = new Set(
    sources.flatMap((source) =>
      [...source.matchAll(/(?:\bt\(|data-t(?:-label|-title|-alt|-content)?=)"([a-z0-9_]+\.[a-z0-9_.]+)"/g)].map(
        ([, key]) => key,
      ),
    ),
  );
  keys.delete("catalog.key"); // of an explanation
  assert.deepEqual(
    [...keys].filter((key) => !hasMessage(key)),
    [],
  );
});

test("pages have no copies of the catalogs' texts", () => {
  for (const name of files("", ".html")) {
    const { document } = parseHTML(readFileSync(new URL(name, WEB), "utf8"));
    for (const { dataset, textContent } of document.querySelectorAll("[data-t]"))
      assert.equal(textContent, "", `${name}: ${dataset.t}`);
    assert.equal(document.querySelector("[data-t-label][aria-label], [data-t-content][content]"), null, `${name}`);
  }
});

test("the language is the requested, stored or preferred one", () => {
  assert.equal(choose("de", "uk", ["en"]), "de");
  assert.equal(choose("fr", "uk", ["en"]), "uk");
  assert.equal(choose(null, null, ["fr-FR", "de-AT", "en"]), "de");
  assert.equal(choose(null, null, ["fr"]), "en");
});

test("values and plural forms are put in", () => {
  addMessages("en", { "trial.views": { one: "{count} view", other: "{count} views" } });
  addMessages("uk", { "trial.views": { few: "{count} вигляди", other: "{count} вигляду" } });
  assert.equal(say("trial.views", { count: 1 }, "en"), "1 view");
  assert.equal(say("trial.views", { count: 3 }, "uk"), "3 вигляди");
  assert.equal(say("trial.none", {}, "en"), "trial.none");
});

test("no line ends between a number and its unit", () => {
  addMessages("en", { "units.a": "{n} px off, 94 % of 3 views, 5 same" });
  assert.equal(say("units.a", { n: 0.4 }, "en"), "0.4\u00a0px off, 94\u00a0% of 3 views, 5 same");
});

test("numbers have the signs and digits of people", () => {
  setLanguage("de");
  assert.equal(number(-0.25, 3), "−0,250");
  assert.equal(number(-0.00001, 4), "0,0000");
  setLanguage("en");
  assert.deepEqual([0.0123, 0.31, 3.14159, 31.4, 314].map(rough), ["0.012", "0.31", "3.1", "31", "314"]);
});

const SCRIPT = readFileSync(new URL("../../web/language.js", import.meta.url), "utf8");

/** Address to which the script of a page's head leads; null if the page stays. */
function visit(address, { kept = null, preferred = ["en-US"], storage = true } = {}) {
  const url = new URL(address, "https://site.example/");
  let led = null;
  let written = "";
  const localStorage = { getItem: () => kept };
  runInNewContext(SCRIPT, {
    URL,
    URLSearchParams,
    navigator: { languages: preferred },
    document: {
      currentScript: { src: "https://site.example/language.js" },
      write: (text) => {
        written += text;
      },
    },
    location: {
      pathname: url.pathname,
      search: url.search,
      hash: url.hash,
      replace: (there) => {
        led = there;
      },
    },
    get localStorage() {
      if (!storage) throw new DOMException("denied", "SecurityError");
      return localStorage;
    },
  });
  // What it leaves is not shown and not run.
  assert.equal(written, led === null ? "" : "<plaintext hidden>");
  return led;
}

test("German and Ukrainian visitors are led to their pages", () => {
  assert.equal(visit("/", { preferred: ["de-AT", "en"] }), "/de/");
  assert.equal(visit("/result/?id=a%20b&x=1#y", { preferred: ["fr", "uk"] }), "/uk/result/?id=a+b&x=1#y");
  assert.equal(visit("/board/", { preferred: ["en", "de"] }), null);
});

test("an address with a language overrides the stored choice", () => {
  assert.equal(visit("/board/", { kept: "de" }), "/de/board/");
  assert.equal(visit("/board/", { kept: "en", preferred: ["de"] }), null);
  assert.equal(visit("/de/board/", { kept: "uk", preferred: ["en"] }), null);
  assert.equal(visit("/design/", { kept: "en" }), null);
  assert.equal(visit("/board/", { storage: false, preferred: ["de"] }), "/de/board/");
});

test("?lang= asks for a language, whatever else is known", () => {
  assert.equal(visit("/calibrate/?virtual=1&lang=uk", { kept: "de" }), "/uk/calibrate/?virtual=1");
  assert.equal(visit("/de/calibrate/?virtual=1&lang=en"), "/calibrate/?virtual=1&lang=en");
  assert.equal(visit("/calibrate/?lang=en", { preferred: ["de"] }), null);
  assert.equal(visit("/de/board/?lang=uk"), "/uk/board/");
  assert.equal(visit("/board/?lang=fr", { preferred: ["de"] }), "/de/board/");
});
