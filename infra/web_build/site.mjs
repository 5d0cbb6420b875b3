// Makes the site's files of their sources: pages in one frame and every language, scripts and styles without comments
// and indentation. `site.py` runs it.
//
// In: {web, pages: {key: source}, origin, code}, JSON. Out: {key: content}, JSON; "de/board/index.html" is the
// German page.
import { existsSync, readFileSync, readdirSync } from "node:fs";
import { readFile } from "node:fs/promises";
import { posix } from "node:path";
import { pathToFileURL } from "node:url";
import { transform } from "esbuild";
import { parseHTML } from "linkedom";
import { LANGUAGES, addMessages, setLanguage, translate } from "../../web/lib/i18n.js";
import { addressOf, frame, head } from "./frame.mjs";
import { mentionedKeys, messagesElement, readMessages } from "./messages.mjs";
import { moduleGraph } from "./module_graph.mjs";

/** Attributes with addresses of files that pages of all languages share. */
const SHARED = { link: "href", script: "src", img: "src", source: "src", video: "poster", a: "href" };
const HERE = "https://here.invalid";
/** Made by others, or examples, which people read. */
const AS_WRITTEN = /^(vendor|examples)\//;

/**
 * Makes addresses right for a page that lies in a folder of its language: files from the root; other pages relative, so
 * that they are in the same language. `key`: of the page in English.
 */
function rewriteAddresses(document, key, inAllLanguages) {
  const relativePages = key.endsWith("index.html") && inAllLanguages.has(key);
  for (const [tag, attribute] of Object.entries(SHARED)) {
    for (const element of document.querySelectorAll(`${tag}[${attribute}]:not([hreflang])`)) {
      const written = element.getAttribute(attribute) ?? "";
      if (/^([a-z]+:|#|\?)/i.test(written)) continue;
      const there = new URL(written, `${HERE}/${key}`);
      const page = there.pathname.slice(1);
      const isSameLanguage = tag === "a" && relativePages && inAllLanguages.has(`${page}index.html`);
      const path = isSameLanguage ? `${posix.relative(posix.dirname(key), page) || "."}/` : there.pathname;
      element.setAttribute(attribute, path + there.search + there.hash);
    }
  }
}

/** Keys of the modules a page begins with. */
const entriesOf = (document) =>
  [...document.querySelectorAll("script[type=module][src]")].map((script) =>
    (script.getAttribute("src") ?? "").replace(/^\//, ""),
  );

export async function buildPages({ web, pages, origin, code }) {
  const languages = Object.keys(LANGUAGES);
  const messages = Object.fromEntries(languages.map((language) => [language, readMessages(web, language)]));
  for (const language of languages) addMessages(language, messages[language]);
  const keys = new Set(Object.keys(pages));
  const inAllLanguages = new Set([...keys].filter((key) => pages[key].includes("data-t=")));
  const entries = new Set(["lib/header.js"]);
  for (const [key, source] of Object.entries(pages)) {
    for (const [, src] of source.matchAll(/<script type="module" src="([^"]+)"/g))
      entries.add(posix.resolve("/", posix.dirname(key), src).slice(1));
  }
  const graph = await moduleGraph(web, [...entries]);
  const texts = Object.fromEntries(
    [...new Set(Object.values(graph).flatMap(({ all }) => all))].map((path) => [
      path,
      existsSync(`${web}/${path}`) ? readFileSync(`${web}/${path}`, "utf8") : "",
    ]),
  );
  const made = {};
  for (const [key, source] of Object.entries(pages)) {
    const translated = inAllLanguages.has(key);
    for (const language of translated ? languages : ["en"]) {
      setLanguage(language);
      const { document } = parseHTML(source);
      const place = { key, language, translated, pages: keys, origin, code };
      frame(document, place);
      translate(document.documentElement);
      rewriteAddresses(document, key, inAllLanguages);
      const own = entriesOf(document);
      if (document.querySelector("header.masthead")) own.push("lib/header.js");
      head(document, place, new Set(own.flatMap((entry) => graph[entry]?.now ?? [])));
      const modules = new Set(own.flatMap((entry) => graph[entry]?.all ?? []));
      const sources = [document.toString(), ...[...modules].map((path) => texts[path])];
      const shown = mentionedKeys(sources, Object.keys(messages[language]));
      const shownTexts = Object.fromEntries(shown.map((name) => [name, messages[language][name]]));
      if (modules.has("lib/i18n.js")) document.body.insertAdjacentHTML("beforeend", messagesElement(shownTexts));
      const address = addressOf(key, language).slice(1);
      made[address.replace(/(^|\/)$/, "$1index.html")] = `${document.toString()}\n`;
    }
  }
  return made;
}

/** Strips comments and indentation of scripts and styles. Names stay: a stack trace is as good as before. */
export async function buildAssets(web) {
  const keys = readdirSync(web, { recursive: true })
    .map((name) => String(name).replaceAll("\\", "/"))
    .filter((name) => /\.(js|css)$/.test(name) && !AS_WRITTEN.test(name))
    .sort();
  const stripped = await Promise.all(
    keys.map(async (key) => {
      const source = await readFile(`${web}/${key}`, "utf8");
      const { code } = await transform(source, {
        loader: key.endsWith(".css") ? "css" : "js",
        minifyWhitespace: true,
        minifySyntax: true,
        legalComments: "none",
        charset: "utf8",
      });
      return [key, code];
    }),
  );
  return Object.fromEntries(stripped);
}

if (existsSync(process.argv[1] ?? "") && import.meta.url === pathToFileURL(process.argv[1]).href) {
  const task = JSON.parse(readFileSync(0, "utf8"));
  process.stdout.write(JSON.stringify({ ...(await buildAssets(task.web)), ...(await buildPages(task)) }));
}
