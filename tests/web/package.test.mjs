import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";
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

test("compressed: 8 KB, 14 KB with the GPU, less for single functions", async (t) => {
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
  t.diagnostic(
    `${without} bytes, ${complete} with all that works on the GPU, ${lens} for lensOf, ` +
      `${matrix} for projectionMatrix, ${lookup} for lookup, ${rig} for rig; ${offline} for Bundle`,
  );
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
