// Frame of every page around its own content: skip link, header with navigation, footer, languages, preloads.
import { LANGUAGES } from "../../web/lib/i18n.js";

/**
 * @typedef {object} Place
 * @property {string} key of the page in English, "board/index.html"
 * @property {import("../../web/lib/i18n.js").Language} language
 * @property {boolean} translated is there a page for each language?
 * @property {Set<string>} pages keys of all pages in English
 * @property {Set<string>} inAllLanguages those of them that are translated
 * @property {string} origin "https://calibdb.example", or "" where it is not known
 * @property {Record<string, string>} contacts addresses of the operator: "contact", "imprint", "source"
 * @property {string[]} preloads paths of modules, from the root
 */

/** Groups and links of the navigation: [message, page] or [message, [[message, page], …]]. */
const NAVIGATION = [
  [
    "common.calibrate",
    [
      ["common.webcam", "calibrate/"],
      ["common.photos_video", "photos/"],
      ["common.import_file", "import/"],
      ["common.board", "board/"],
    ],
  ],
  ["common.cameras", "cameras/"],
  ["common.mine", "mine/"],
  ["common.docs", "docs/"],
  ["common.examples", "examples/"],
];
const FOOTER = [
  ["common.docs", "docs/"],
  ["common.api", "docs/api/"],
  ["common.developers", "developers/"],
  ["common.data", "data/"],
  ["common.privacy", "privacy/"],
  ["common.terms", "terms/"],
  ["common.status", "status/"],
];
const OPERATORS = { contact: "common.contact", imprint: "common.imprint", source: "common.source" };

/** The address of a page, from the root. */
export function addressOf(key, language) {
  return `/${language === "en" ? "" : `${language}/`}${key.replace(/(^|\/)index\.html$/, "$1")}`;
}

/** Puts the common parts into a page. */
export function frame(document, place) {
  head(document, place);
  const header = document.querySelector("header.masthead");
  if (header) header.outerHTML = masthead(place);
  const select = document.querySelector("header.rim > #language");
  if (select && place.translated) select.outerHTML = languageSelect(place.language);
  // Where one looks through a camera there is no room for more than the way back.
  document
    .querySelector("header.rim > .brand")
    ?.insertAdjacentHTML("afterend", `<a class="back" href="${toPage("", place)}" data-t="common.back"></a>`);
  // The result of a capture is read like any page.
  if (document.getElementById("done"))
    document.querySelector("header.rim > .fill")?.insertAdjacentHTML("afterend", navigation(place, "site"));
  document.querySelector(".page")?.insertAdjacentHTML("beforeend", foot(place));
  skipLink(document);
}

function head(document, { key, language, translated, origin, preloads }) {
  const classic = [
    ...(translated ? ["language"] : []),
    ...(document.querySelector("script[type=module]") ? ["arrival"] : []),
  ];
  const first = [
    '<meta charset="utf-8">',
    ...(document.querySelector("meta[name=viewport]")
      ? []
      : ['<meta name="viewport" content="width=device-width, initial-scale=1">']),
    ...classic.map((name) => `<script src="/${name}.js"></script>`),
  ];
  document.head.insertAdjacentHTML("afterbegin", first.map((line) => `\n  ${line}`).join(""));
  const about = document.querySelector("meta[name=description]") ?? document.querySelector("title");
  about?.insertAdjacentHTML(
    "afterend",
    '\n  <link rel="icon" href="/icon.svg" type="image/svg+xml">\n  <link rel="stylesheet" href="/style.css">',
  );
  for (const link of document.querySelectorAll("link[rel=modulepreload]:not([as])")) link.remove();
  const [style] = [...document.querySelectorAll("link[rel=stylesheet]")].slice(-1);
  const alphabets = language === "uk" ? ["latin", "cyrillic"] : ["latin"];
  const hasHeader = document.querySelector("header.masthead");
  const lines = [
    '<link rel="manifest" href="/manifest.json">',
    ...alphabets.map(
      (name) =>
        `<link rel="preload" href="/vendor/font/geologica-${name}.woff2" as="font" type="font/woff2" crossorigin>`,
    ),
    ...preloads.map((path) => `<link rel="modulepreload" href="${path}">`),
    ...(hasHeader ? ['<script type="module" src="/lib/header.js"></script>'] : []),
    ...addresses(key, language, translated, origin),
  ];
  const social = [
    ["og:type", "website"],
    ["og:site_name", "calibDB"],
    ["og:image", origin && `${origin}/social.png`],
    ["og:title", document.title],
    ["og:description", document.querySelector("meta[name=description]")?.getAttribute("content") ?? ""],
  ]
    .filter(([name, content]) => content && !document.querySelector(`meta[property="${name}"]`))
    .map(([name, content]) => `<meta property="${name}" content="${escape(content)}">`);
  style?.insertAdjacentHTML("afterend", [...lines, ...social].map((line) => `\n  ${line}`).join(""));
}

/** Links to the page in each language. Without an origin they are from the root, which search engines ignore. */
function addresses(key, language, translated, origin) {
  if (!key.endsWith("index.html")) return [];
  const canonical = `<link rel="canonical" href="${origin}${addressOf(key, language)}">`;
  if (!translated) return [canonical];
  const alternate = (name, code) => `<link rel="alternate" hreflang="${name}" href="${origin}${addressOf(key, code)}">`;
  return [canonical, ...Object.keys(LANGUAGES).map((code) => alternate(code, code)), alternate("x-default", "en")];
}

/** Path from this page to another one in the same language. */
function toPage(page, { key, inAllLanguages, translated }) {
  // 404.html is shown at any address.
  if (!key.endsWith("index.html") || !translated || !inAllLanguages.has(`${page}index.html`)) return `/${page}`;
  return `${"../".repeat(key.split("/").length - 1) || "./"}${page}`;
}

function masthead(place) {
  const current = place.key === "index.html" ? ' aria-current="page"' : "";
  return `<header class="masthead">
      <a class="brand" href="${toPage("", place)}"${current}>calibDB</a>
      ${navigation(place)}
      ${place.translated ? languageSelect(place.language) : ""}
    </header>`;
}

function navigation(place, name = "") {
  const here = place.key.replace(/index\.html$/, "");
  const item = ([message, page]) =>
    `<a href="${toPage(page, place)}"${here === page ? ' aria-current="page"' : ""} data-t="${message}"></a>`;
  const there = ([, page]) => place.pages.has(`${page}index.html`);
  const parts = NAVIGATION.map(([message, target]) => {
    if (typeof target === "string") return there([message, target]) ? item([message, target]) : "";
    const inside = target.some(([, page]) => page === here) ? ' class="within"' : "";
    const links = target
      .filter(there)
      .map((one) => `<li>${item(one)}</li>`)
      .join("");
    const summary = `<summary${inside}><span data-t="${message}"></span></summary>`;
    return `<details class="menu">${summary}<ul>${links}</ul></details>`;
  });
  return `<nav${name && ` class="${name}"`} aria-label="Pages" data-t-label="common.pages">${parts.join("")}</nav>`;
}

function languageSelect(spoken) {
  const options = Object.entries(LANGUAGES).map(
    ([code, name]) => `<option value="${code}" lang="${code}"${code === spoken ? " selected" : ""}>${name}</option>`,
  );
  const labels = 'data-t-label="common.language" aria-label="Language"';
  return `<select class="language" id="language" ${labels}>${options.join("")}</select>`;
}

function foot(place) {
  const links = FOOTER.filter(([, page]) => place.pages.has(`${page}index.html`)).map(
    ([message, page]) => `<li><a href="${toPage(page, place)}" data-t="${message}"></a></li>`,
  );
  const outside = Object.entries(OPERATORS)
    .filter(([name]) => place.contacts[name])
    .map(([name, message]) => `<li><a href="${escape(place.contacts[name])}" data-t="${message}"></a></li>`);
  const languages = place.translated
    ? Object.entries(LANGUAGES)
        .filter(([code]) => code !== place.language)
        .map(([code, name]) => {
          const address = `${addressOf(place.key, code)}${code === "en" ? "?lang=en" : ""}`;
          return `<li><a href="${address}" lang="${code}" hreflang="${code}">${name}</a></li>`;
        })
    : [];
  return `<footer class="foot">
      <nav aria-label="Footer" data-t-label="common.footer"><ul>${[...links, ...outside].join("")}</ul></nav>
      <ul class="languages">${languages.join("")}</ul>
      <p><span data-t="common.licence"></span> <span data-t="common.method"></span></p>
    </footer>`;
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
