import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import { build } from "esbuild";

const root = fileURLToPath(new URL("../..", import.meta.url));
const sdk = join(root, "web/sdk");

/** Bytes of what a bundler makes of a line of code, compressed. */
async function size(contents, external = []) {
  const { outputFiles: [{ text }] } = await build({
    stdin: { contents, resolveDir: sdk }, bundle: true, minify: true, write: false, format: "esm", external, logLevel: "silent",
  });
  return gzipSync(text).length;
}

test("below 8 KB compressed, below 14 KB with all that works on the GPU, and less for those who want less", async (t) => {
  const all = "export * from './calibdb.js';";
  const gpu = ["./rectifier.js", "./distorter.js", "./pair-rectifier.js"];
  const [without, complete, matrix, lens, lookup, rig, offline] = await Promise.all([
    size(all, gpu), size(`${all} ${gpu.map((each) => `export * from '${each}';`).join(" ")}`),
    size("export { projectionMatrix } from './calibdb.js';"), size("export { lensOf } from './calibdb.js';"),
    size("export { lookup } from './calibdb.js';", gpu), size("export { rig, rectifyPair } from './calibdb.js';", gpu), size("export { Bundle } from './bundle.js';"),
  ]);
  t.diagnostic(`${without} bytes, ${complete} with all that works on the GPU, ${lens} for lensOf, ${matrix} for projectionMatrix, ${lookup} for lookup, ${rig} for rig; ${offline} for Bundle`);
  assert.ok(without < 8192 && complete < 14336, `${without}, ${complete}`);
  assert.ok(lens < 0.5 * without && matrix < 0.1 * without && lookup < 0.8 * without && rig < 0.7 * without, `${lens}, ${matrix}, ${lookup}, ${rig}: tree-shakeable`);
  assert.ok(offline < 1536, `${offline}`);
});

test("who looks up alone carries nothing else", async () => {
  const { metafile } = await build({
    stdin: { contents: "export { lookup } from './calibdb.js';", resolveDir: sdk }, bundle: true, minify: true, write: false, format: "esm",
    metafile: true, external: ["./rectifier.js", "./distorter.js"], logLevel: "silent",
  });
  const [{ inputs }] = Object.values(metafile.outputs);
  const carried = Object.entries(inputs).filter(([, { bytesInOutput }]) => bytesInOutput > 0).map(([path]) => path.split("/").at(-1));
  assert.deepEqual(carried.sort(), ["calibration.js", "edge.js", "key.js", "lookup.js", "pinhole.js", "projection.js", "request.js", "retry.js"]);
});

test("bundlers that pack every `new URL(…, import.meta.url)` find none", () => {
  const files = readdirSync(sdk, { recursive: true, encoding: "utf8" }).filter((name) => name.endsWith(".js"));
  assert.ok(files.length > 10);
  for (const name of files) {
    const code = readFileSync(join(sdk, name), "utf8").replaceAll(/\/\*.*?\*\/|\/\/.*/gs, "");
    assert.ok(!/new URL\([^)]*import\.meta/.test(code), `${name}: webpack would look for that file`);
  }
});

test("packed, it installs into an empty project, with types", { timeout: 60_000 }, () => {
  const folder = mkdtempSync(join(tmpdir(), "calibdb-"));
  const run = (command, ...parameters) => execFileSync(command, parameters, { cwd: folder, encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });
  try {
    const [{ filename }] = JSON.parse(execFileSync("npm", ["pack", "--json", "--pack-destination", folder], {
      cwd: sdk, encoding: "utf8", stdio: ["ignore", "pipe", "ignore"], env: { ...process.env, PATH: `${root}node_modules/.bin:${process.env.PATH}` },
    }));
    writeFileSync(join(folder, "package.json"), '{"type": "module"}');
    run("npm", "install", "--offline", "--no-audit", "--no-fund", `./${filename}`);
    const { dependencies } = JSON.parse(readFileSync(join(folder, "node_modules/calibdb/package.json"), "utf8"));
    assert.equal(dependencies, undefined);
    assert.ok(existsSync(join(folder, "node_modules/calibdb/LICENSE")));
    writeFileSync(join(folder, "use.mjs"), "import { lookup, projectionMatrix } from 'calibdb'; import { lensOf } from 'calibdb/projection'; import { Bundle } from 'calibdb/bundle'; import { Rig } from 'calibdb/rig'; import { applyCalibration } from 'calibdb/adapters/three'; console.log(typeof lookup, typeof lensOf, typeof Bundle, typeof Rig, typeof applyCalibration);");
    assert.equal(run("node", "use.mjs").trim(), "function function function function function");
    const use = (/** @type {string} */ model) => `import { lookup, type Calibration } from "calibdb";
      const { calibration } = await lookup({ camera: "x", platform: "y", img_size: [640, 480], zoom: 0 }, { token: "t", model: ${model} });
      export const known: Calibration | null = calibration;
      export const at: [number, number] | null | undefined = calibration?.project([0, 0, 1]);`;
    const offline = `import { Bundle } from "calibdb/bundle"; import { applyCalibration } from "calibdb/adapters/babylon";
      export const found = async (text: string) => lookup({ camera: "x", platform: "y", img_size: [640, 480], zoom: 0 }, { bundle: new Bundle(JSON.parse(text)), token: text.length ? text : undefined });
      export type Eye = Parameters<typeof applyCalibration>[0];`;
    writeFileSync(join(folder, "use.ts"), use('"fisheye"') + offline);
    writeFileSync(join(folder, "misuse.ts"), use("5"));
    writeFileSync(join(folder, "page.ts"), `import { Rectifier } from "calibdb/rectifier"; import { Calibration } from "calibdb";
      export const show = async (calibration: Calibration) => document.body.append((await calibration.rectifier({ balance: 1 })).canvas, (await calibration.distorter()).canvas);
      export const unseen = (calibration: Calibration) => new Rectifier(calibration, { canvas: new OffscreenCanvas(1, 1) }).canvas.transferToImageBitmap();`);
    writeFileSync(join(folder, "pair.ts"), `import { rectifyPair, rig, type PairRectifier, type Pose, type View } from "calibdb"; import { rectify } from "calibdb/stereo";
      export const show = async (left: HTMLVideoElement, right: HTMLVideoElement, frame: VideoFrame) => {
        const known = await rig("id", { token: "t" });
        const pair: PairRectifier = await rectifyPair(left, right, known, { scale: 0.5, positions: [1, 2] });
        const pose: Pose = known.pose(1);
        document.body.append(pair.left, pair.right);
        const away = await rectifyPair(frame, frame, { left: known.calibrations[0], right: known.calibrations[1], pose }, { packing: "beside", canvases: [new OffscreenCanvas(1, 1), new OffscreenCanvas(1, 1)] });
        const eyes: View[] = [...known.toMetres(0.03).views({ near: 0.1 }), ...pair.views()];
        return [pair.draw(), pair.depth(10), pair.point([1, 2], 3)[2], away.left.transferToImageBitmap(), eyes[0].transform.matrix, rectify(known.calibrations[0], known.calibrations[1], pose).Q];
      };`);
    writeFileSync(join(folder, "worker.ts"), `import { lookup, type CameraKey } from "calibdb";
      onmessage = async ({ data }: MessageEvent<CameraKey>) => postMessage((await lookup(data, { token: "t" })).calibration?.camera_matrix);`);
    const check = (/** @type {string} */ file, resolution = "bundler", lib = "es2023,dom") => run(
      `${root}node_modules/.bin/tsc`, file, "--ignoreConfig", "--noEmit", "--strict", "--exactOptionalPropertyTypes", "--target", "es2023",
      "--module", resolution === "bundler" ? "esnext" : resolution, "--moduleResolution", resolution, "--lib", lib, "--skipLibCheck", "false",
    );
    for (const resolution of ["bundler", "node16"]) for (const file of ["use.ts", "page.ts", "pair.ts"]) check(file, resolution);
    check("worker.ts", "bundler", "es2023,webworker");
    assert.throws(() => check("misuse.ts"), (/** @type {any} */ error) => /'number' is not assignable/.test(error.stdout));
  } finally {
    rmSync(folder, { recursive: true });
  }
});
