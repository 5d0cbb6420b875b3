import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { join, posix } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import { build } from "esbuild";

const root = fileURLToPath(new URL("../..", import.meta.url));
const sdk = join(root, "web/sdk");

/** Bytes of what a bundler makes of a line of code, compressed. */
async function size(contents, external = []) {
  const {
    outputFiles: [{ text }],
  } = await build({
    stdin: { contents, resolveDir: sdk },
    bundle: true,
    minify: true,
    write: false,
    format: "esm",
    external,
    logLevel: "silent",
  });
  return gzipSync(text).length;
}

test("compressed: 8 KB, 14 KB with the GPU, less for single functions", async () => {
  const all = "export * from './calibdb.js';";
  const gpu = ["./rectifier.js", "./distorter.js", "./pair-rectifier.js"];
  const [without, complete, matrix, lens, lookup, rig, offline] = await Promise.all([
    size(all, gpu),
    size(`${all} ${gpu.map((each) => `export * from '${each}';`).join(" ")}`),
    size("export { projectionMatrix } from './calibdb.js';"),
    size("export { lensOf } from './calibdb.js';"),
    size("export { lookup } from './calibdb.js';", gpu),
    size("export { rig, rectifyPair } from './calibdb.js';", gpu),
    size("export { Bundle } from './bundle.js';"),
  ]);
  assert.ok(without < 8192 && complete < 14336, `${without}, ${complete}`);
  assert.ok(
    lens < 0.5 * without && matrix < 0.1 * without && lookup < 0.8 * without && rig < 0.7 * without,
    `${lens}, ${matrix}, ${lookup}, ${rig}: tree-shakeable`,
  );
  assert.ok(offline < 1536, `${offline}`);
});

test("bundlers that pack every `new URL(…, import.meta.url)` find none", () => {
  const files = readdirSync(sdk, { recursive: true, encoding: "utf8" }).filter((name) => name.endsWith(".js"));
  assert.ok(files.length > 10);
  for (const name of files) {
    const code = readFileSync(join(sdk, name), "utf8").replaceAll(/\/\*.*?\*\/|\/\/.*/gs, "");
    assert.ok(!/new URL\([^)]*import\.meta/.test(code), `${name}: webpack would look for that file`);
  }
});

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
