// Static imports of the pages' modules: what a browser must have before a page's script can run.
import { existsSync } from "node:fs";
import { posix } from "node:path";
import { build } from "esbuild";

const UNWRITTEN = "/unwritten"; // esbuild's paths to files it was told to leave are relative to here

/**
 * @param {string} web folder of the client
 * @param {string[]} entries keys of the modules that pages begin with, "board/main.js"
 * @returns {Promise<Record<string, string[]>>} of each entry: it and all that it imports, near ones first; those imported
 *    dynamically are left out
 */
export async function moduleGraph(web, entries) {
  const present = entries.filter((entry) => existsSync(`${web}/${entry}`));
  if (!present.length) return {};
  const { metafile } = await build({
    absWorkingDir: web, entryPoints: present, outdir: UNWRITTEN, bundle: true, write: false, metafile: true, format: "esm",
    external: [`${web}/vendor/*`], logLevel: "silent",
  });
  return Object.fromEntries(present.map((entry) => [entry, reached(metafile.inputs, entry, web)]));
}

/** @param {import("esbuild").Metafile["inputs"]} inputs @param {string} entry @param {string} web */
function reached(inputs, entry, web) {
  const found = new Set([entry]);
  for (const name of found) {
    for (const { path, kind, external } of inputs[name]?.imports ?? []) {
      if (kind === "import-statement") found.add(external ? posix.relative(web, posix.resolve(UNWRITTEN, path)) : path);
    }
  }
  return [...found];
}
