// Messages that a page may show: those that its markup, its modules and the modules they load later mention.
import { readFileSync, readdirSync } from "node:fs";
import { basename } from "node:path";

/** @typedef {Record<string, import("../../web/lib/i18n.js").Text>} Texts by "catalog.key" */

/** All catalogs of a language. @returns {Texts} */
export function readMessages(web, language) {
  const folder = `${web}/messages/${language}`;
  const texts = {};
  for (const file of readdirSync(folder).sort()) {
    const catalog = JSON.parse(readFileSync(`${folder}/${file}`, "utf8"));
    for (const [key, text] of Object.entries(catalog)) texts[`${basename(file, ".json")}.${key}`] = text;
  }
  return texts;
}

/**
 * Keys that sources mention. Besides whole keys: "catalog.part_" and `catalog.part_${code}` mention all keys that begin
 * so, `catalog.${name}` and `catalog.${name}_part` those whose names the same source contains, and `${catalog}.name`
 * that name in any catalog.
 */
export function mentionedKeys(sources, keys) {
  const catalogs = [...new Set(keys.map((key) => key.slice(0, key.indexOf("."))))];
  const written = new RegExp(`(?<=["'\`])(?:${catalogs.join("|")})\\.[a-z0-9_.]+`, "g");
  const whole = new Set(sources.flatMap((source) => source.match(written) ?? []));
  const beginnings = [...whole].filter((key) => /[._]$/.test(key));
  const composed = new Set(
    sources.flatMap((source) =>
      [...source.matchAll(/["'`](\w+)\.\$?\{[^}]*\}(\w*)/g)].flatMap(([, catalog, part]) =>
        [...source.matchAll(/["'`](\w+)["'`]/g)].map(([, key]) => `${catalog}.${key}${part}`),
      ),
    ),
  );
  const names = new Set(sources.flatMap((source) => [...source.matchAll(/\$\{\w+\}\.(\w+)`/g)].map(([, key]) => key)));
  return keys.filter(
    (key) =>
      whole.has(key) ||
      composed.has(key) ||
      names.has(key.slice(key.indexOf(".") + 1)) ||
      beginnings.some((beginning) => key.startsWith(beginning)),
  );
}

/** An element with a page's messages, for web/lib/i18n.js. */
export function messagesElement(texts) {
  return `<script type="application/json" id="messages">${JSON.stringify(texts).replaceAll("<", "\\u003c")}</script>`;
}
