// Messages that a page may show: those that its markup, its modules and the modules they load later mention.
import { readFileSync, readdirSync } from "node:fs";

/** @typedef {Record<string, import("../../web/lib/i18n.js").Text>} Texts by "catalog.key" */

/**
 * All catalogs of a language.
 * @param {string} web folder of the client @param {string} language
 * @returns {Texts}
 */
export function readMessages(web, language) {
  const folder = `${web}/messages/${language}`;
  return Object.fromEntries(
    readdirSync(folder)
      .filter((file) => file.endsWith(".json"))
      .sort()
      .flatMap((file) => {
        const catalog = file.slice(0, -".json".length);
        return Object.entries(JSON.parse(readFileSync(`${folder}/${file}`, "utf8"))).map(([key, text]) => [
          `${catalog}.${key}`,
          text,
        ]);
      }),
  );
}

/**
 * Keys that sources mention. Besides whole keys: "catalog.part_" and `catalog.part_${code}` mention all keys that begin
 * so,
 * `catalog.${name}` those whose names the same source contains, and `${catalog}.name` that name in any catalog.
 * @param {readonly string[]} sources @param {readonly string[]} keys
 * @returns {string[]}
 */
export function mentionedKeys(sources, keys) {
  const catalogs = [...new Set(keys.map((key) => key.slice(0, key.indexOf("."))))];
  const written = new RegExp(`(?<=["'\`])(?:${catalogs.join("|")})\\.[a-z0-9_.]+`, "g");
  const whole = new Set(sources.flatMap((source) => source.match(written) ?? []));
  const beginnings = [...whole].filter((key) => /[._]$/.test(key));
  const composed = new Set(
    sources.flatMap((source) =>
      [...source.matchAll(/["'`](\w+)\.\$?\{/g)].flatMap(([, catalog]) =>
        [...source.matchAll(/["'`](\w+)["'`]/g)].map(([, key]) => `${catalog}.${key}`),
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

/** An element with a page's messages, for web/lib/i18n.js. @param {Texts} texts */
export function messagesElement(texts) {
  return `<script type="application/json" id="messages">${JSON.stringify(texts).replaceAll("<", "\\u003c")}</script>`;
}
