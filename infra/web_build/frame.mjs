// Frame of every page around its own content: skip link, header with navigation, footer, languages, preloads.
import { readFileSync } from "node:fs";
import { LANGUAGES } from "../../web/lib/i18n.js";

/**
 * @typedef {object} Place
 * @property {string} key of the page in English, "board/index.html"
 * @property {import("../../web/lib/i18n.js").Language} language
 * @property {boolean} translated is there a page for each language?
 * @property {Set<string>} pages keys of all pages in English
 * @property {string} origin "https://calibdb.example", or "" where it is not known
 * @property {string} code address of the source code, or ""
 */

/** The address of a page, from the root. */
export function addressOf(key, language) {
  return `/${language === "en" ? "" : `${language}/`}${key.replace(/(^|\/)index\.html$/, "$1")}`;
}

/** HTML that several pages share. */
const part = (name) => readFileSync(new URL(`../../web/templates/parts/${name}.html`, import.meta.url), "utf8").trim();

/** Puts the common parts into a page, and for each `<div data-part="consent">` the part of that name. */
export function frame(document, { key, language, translated, pages, code }) {
  const header = document.querySelector("header.masthead");
  if (header) header.outerHTML = part("masthead");
  // Where one looks through a camera there is no room for more than the way back.
  document
    .querySelector("header.rim > .brand")
    ?.insertAdjacentHTML("afterend", '<a class="back" href="/" data-t="common.back"></a>');
  // The result of a capture is read like any page.
  const navigation = part("navigation").replace("<nav", '<nav class="site"');
  if (document.getElementById("done"))
    document.querySelector("header.rim > .fill")?.insertAdjacentHTML("afterend", navigation);
  document.querySelector(".page")?.insertAdjacentHTML("beforeend", part("foot"));
  for (const place of document.querySelectorAll("[data-part]")) place.outerHTML = part(place.dataset.part);

  for (const link of document.querySelectorAll(":is(.masthead, .site, .foot) a[href^='/']")) {
    const page = `${link.getAttribute("href").slice(1)}index.html`;
    if (!pages.has(page) && !link.matches(".brand")) (link.closest("li") ?? link).remove();
    if (page === key && !link.closest(".foot")) link.setAttribute("aria-current", "page");
  }
  const source = document.querySelector(".foot a[data-t='common.source']");
  if (code) source?.setAttribute("href", code);
  else source?.closest("li").remove();
  document.querySelector(".menu:has([aria-current]) > summary")?.setAttribute("class", "within");
  const select = document.querySelector("header > #language");
  select?.setAttribute("data-t-label", "common.language");
  if (translated) offerLanguages(document, select, key, language);
  else select?.remove();
  skipLink(document);
}

function offerLanguages(document, select, key, language) {
  for (const [code, name] of Object.entries(LANGUAGES)) {
    const isSpoken = code === language;
    const option = `<option value="${code}" lang="${code}"${isSpoken ? " selected" : ""}>${name}</option>`;
    select?.insertAdjacentHTML("beforeend", option);
    if (isSpoken) continue;
    const address = `${addressOf(key, code)}${code === "en" ? "?lang=en" : ""}`;
    const link = `<li><a href="${address}" lang="${code}" hreflang="${code}">${name}</a></li>`;
    document.querySelector(".foot > .languages")?.insertAdjacentHTML("beforeend", link);
  }
}

/** Completes a page's head. `preloads`: keys of modules. */
export function head(document, { key, language, translated, origin }, preloads) {
  const classic = [
    ...(translated ? ["language"] : []),
    ...(document.querySelector("script[type=module]") ? ["arrival"] : []),
  ];
  const viewport = '<meta name="viewport" content="width=device-width, initial-scale=1">';
  insert(document.head, "afterbegin", [
    '<meta charset="utf-8">',
    ...(document.querySelector("meta[name=viewport]") ? [] : [viewport]),
    ...classic.map((name) => `<script src="/${name}.js"></script>`),
  ]);
  const description = document.querySelector("meta[name=description]");
  insert(description ?? document.querySelector("title"), "afterend", [
    '<link rel="icon" href="/icon.svg" type="image/svg+xml">',
    '<link rel="stylesheet" href="/style.css">',
  ]);
  const alphabets = language === "uk" ? ["latin", "cyrillic"] : ["latin"];
  const social = [
    ["og:type", "website"],
    ["og:site_name", "calibDB"],
    ["og:image", origin && `${origin}/social.png`],
    ["og:title", document.title],
    ["og:description", description?.getAttribute("content")],
  ];
  insert([...document.querySelectorAll("link[rel=stylesheet]")].at(-1), "afterend", [
    '<link rel="manifest" href="/manifest.json">',
    ...alphabets.map(
      (name) =>
        `<link rel="preload" href="/vendor/font/geologica-${name}.woff2" as="font" type="font/woff2" crossorigin>`,
    ),
    ...[...preloads].map((path) => `<link rel="modulepreload" href="/${path}">`),
    ...(document.querySelector("header.masthead") ? ['<script type="module" src="/lib/header.js"></script>'] : []),
    ...(key.endsWith("index.html") ? languageLinks(key, language, translated, origin) : []),
    ...social
      .filter(([, content]) => content)
      .map(([name, content]) => `<meta property="${name}" content="${escape(content)}">`),
  ]);
}

const insert = (element, place, lines) =>
  element?.insertAdjacentHTML(place, lines.map((line) => `\n  ${line}`).join(""));

/** Links to the page in each language. Without an origin they are from the root, which search engines ignore. */
function languageLinks(key, language, translated, origin) {
  const canonical = `<link rel="canonical" href="${origin}${addressOf(key, language)}">`;
  if (!translated) return [canonical];
  const alternate = (name, code) => `<link rel="alternate" hreflang="${name}" href="${origin}${addressOf(key, code)}">`;
  return [canonical, ...Object.keys(LANGUAGES).map((code) => alternate(code, code)), alternate("x-default", "en")];
}

function skipLink(document) {
  const main = document.querySelector("main");
  if (!main) return;
  if (!main.id) main.id = "content";
  if (!main.hasAttribute("tabindex")) main.setAttribute("tabindex", "-1");
  document.body.insertAdjacentHTML("afterbegin", `\n  <a class="skip" href="#${main.id}" data-t="common.skip"></a>`);
}

function escape(text) {
  return text.replaceAll("&", "&amp;").replaceAll('"', "&quot;").replaceAll("<", "&lt;");
}
