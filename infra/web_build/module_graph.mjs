// Imports of the pages' modules: what a browser must have before a page's script can run, and what it may load later.
import { existsSync } from "node:fs";
import { posix } from "node:path";
import { build } from "esbuild";

const UNWRITTEN = "/unwritten"; // esbuild's paths to external files are relative to this folder

/**
 * For each of the modules that pages begin with, "board/main.js": `now`, it and all that it imports, near ones first,
 * and `all`, with dynamic imports.
 */
export async function moduleGraph(web, entries) {
  const present = entries.filter((entry) => existsSync(`${web}/${entry}`));
  if (!present.length) return {};
  const { metafile } = await build({
    absWorkingDir: web,
    entryPoints: present,
    outdir: UNWRITTEN,
    bundle: true,
    write: false,
    metafile: true,
    format: "esm",
    external: [`${web}/vendor/*`],
    logLevel: "silent",
  });
  return Object.fromEntries(
    present.map((entry) => [
      entry,
      {
        now: reached(metafile.inputs, entry, web, ["import-statement"]),
        all: reached(metafile.inputs, entry, web, ["import-statement", "dynamic-import"]),
      },
    ]),
  );
}

function reached(inputs, entry, web, kinds) {
  const found = new Set([entry]);
  for (const name of found) {
    for (const { path, kind, external } of inputs[name]?.imports ?? []) {
      if (kinds.includes(kind)) found.add(external ? posix.relative(web, posix.resolve(UNWRITTEN, path)) : path);
    }
  }
  return [...found];
}
