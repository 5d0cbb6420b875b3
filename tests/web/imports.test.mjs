import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { posix } from "node:path";
import { test } from "node:test";

const WEB = new URL("../../web/", import.meta.url);
const SPECIFIER = /(?:\bfrom|\bimport)\s*\(?\s*"(\.[^"]+)"/g;
const modules = readdirSync(WEB, { recursive: true, encoding: "utf8" })
  .map((name) => name.replaceAll("\\", "/"))
  .filter((name) => name.endsWith(".js") && !name.startsWith("vendor/"));
/** Without line comments, which show how modules are used. @param {string} name */
const source = (name) => readFileSync(new URL(name, WEB), "utf8").replaceAll(/^\s*\/\/.*$/gm, "");
/** Modules that each module imports, those included that it takes types from. */
const imports = new Map(
  modules.map((name) => [
    name,
    [
      ...new Set(
        [...source(name).matchAll(SPECIFIER)].map(([, specifier]) => posix.join(posix.dirname(name), specifier)),
      ),
    ],
  ]),
);
const folder = (name) => (name.includes("/") ? name.split("/")[0] : "");
/** Folders that a folder may import from beside itself; a page may import from those of the last line. */
const ALLOWED = {
  sdk: [],
  webxr: ["sdk", "vendor"],
  messages: ["lib"],
  lib: ["sdk", "messages", "vendor"],
};
const PAGE = ["lib", "sdk", "webxr", "messages", "vendor"];

test("imports between folders are allowed ones", () => {
  assert.ok(modules.length > 100);
  const wrong = [];
  for (const [name, targets] of imports) {
    const from = folder(name);
    const allowed = [from, ...(ALLOWED[from] ?? PAGE)];
    wrong.push(
      ...targets.filter((target) => !allowed.includes(folder(target))).map((target) => `${name} -> ${target}`),
    );
  }
  assert.deepEqual(wrong, []);
});

test("no modules import each other in a circle, nor take types so", () => {
  const done = new Set();
  const cycles = [];
  const visit = (name, path) => {
    if (path.includes(name)) return void cycles.push([...path.slice(path.indexOf(name)), name].join(" -> "));
    if (done.has(name)) return;
    for (const target of imports.get(name) ?? []) visit(target, [...path, name]);
    done.add(name);
  };
  for (const name of modules) visit(name, []);
  assert.deepEqual(cycles, []);
});
