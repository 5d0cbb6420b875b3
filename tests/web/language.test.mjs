import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { runInNewContext } from "node:vm";

const SCRIPT = readFileSync(new URL("../../web/language.js", import.meta.url), "utf8");

/**
 * Runs the script of a page's head at an address.
 * @returns {string | null} the address that it leads to; null where the page stays
 */
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

test("who reads German or Ukrainian is led there from an English address, with query and fragment", () => {
  assert.equal(visit("/", { preferred: ["de-AT", "en"] }), "/de/");
  assert.equal(visit("/result/?id=a%20b&x=1#y", { preferred: ["fr", "uk"] }), "/uk/result/?id=a+b&x=1#y");
  assert.equal(visit("/board/"), null);
  assert.equal(visit("/board/", { preferred: ["fr-FR"] }), null);
  assert.equal(visit("/board/", { preferred: ["en", "de"] }), null);
});

test("a choice made before is kept, and an address with a language decides", () => {
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
  assert.equal(visit("/de/board/?lang=de"), null);
  assert.equal(visit("/board/?lang=fr", { preferred: ["de"] }), "/de/board/");
});
