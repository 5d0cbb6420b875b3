// The package in other people's builds: it installs with types, Vite and webpack bundle it, and what they make runs.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { copyFileSync, existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath, pathToFileURL } from "node:url";

const root = fileURLToPath(new URL("../..", import.meta.url));
const tools = join(root, ".build/bundlers");
/** An application: a lookup answered by a stub, a projection matrix for three.js. It says what it found. */
const APPLICATION = `
import { lookup, rectifyPair, rig } from "calibdb";
import { applyCalibration } from "calibdb/adapters/three";
import { lensOf } from "calibdb/projection";

const answer = { img_size: [640, 480], camera_matrix: [[500, 0, 320], [0, 500, 240], [0, 0, 1]],
  distortion_model: "rectilinear", distortion_coefficients: [0, 0, 0, 0, 0], exact_size: true, reliable: true };
const still = { rvec: [0, 0, 0], tvec: [0, 0, 0] };
const pair = { calibrations: [answer, answer], extrinsics: [{ position: 0, ...still }, { position: 1, ...still }] };
const headers = { "content-type": "application/json" };
const fetch = async (url) => new Response(JSON.stringify(/rigs/.test(url) ? pair : answer), { headers });
const key = { camera: "A camera", platform: "X11; Linux x86_64", img_size: [640, 480], zoom: 0 };
const { calibration } = await lookup(key, { token: "t", api: "https://calibdb.example/v1", fetch, cache: null });
const stereo = await rig("1f0c", { token: "t", api: "https://calibdb.example/v1", fetch });
globalThis.found = [
  calibration.project([0.1, 0, 1]), typeof applyCalibration, typeof lensOf,
  calibration.projectionMatrix({ near: 1, far: 2 }).length, stereo.pose(1).tvec, typeof rectifyPair,
];
`;
const EXPECTED = [[370, 240], "function", "function", 16, [0, 0, 0], "function"];

let missing = "";
let folder;

before(() => {
  mkdirSync(tools, { recursive: true });
  for (const name of ["package.json", "package-lock.json", ".npmrc"])
    copyFileSync(join(root, "tests/web/bundlers", name), join(tools, name));
  try {
    const options = ["--silent", "--no-audit", "--no-fund", "--prefer-offline", "--fetch-retries", "1"];
    execFileSync("npm", ["install", ...options], { cwd: tools, stdio: "ignore" });
  } catch (error) {
    missing = "Vite and webpack cannot be installed: npm's registry does not answer";
  }
  folder = mkdtempSync(join(tmpdir(), "calibdb-bundlers-"));
  writeFileSync(join(folder, "package.json"), '{"type": "module"}');
  writeFileSync(join(folder, "main.js"), APPLICATION);
  writeFileSync(join(folder, "index.html"), '<!doctype html><script type="module" src="/main.js"></script>');
  const [{ filename }] = JSON.parse(
    execFileSync("npm", ["pack", "--json", "--pack-destination", folder], {
      cwd: join(root, "web/sdk"),
      encoding: "utf8",
      stdio: ["ignore", "pipe", "ignore"],
      env: { ...process.env, PATH: `${root}node_modules/.bin:${process.env.PATH}` },
    }),
  );
  execFileSync("npm", ["install", "--offline", "--silent", "--no-audit", "--no-fund", `./${filename}`], {
    cwd: folder,
    stdio: "ignore",
  });
});

after(() => rmSync(folder, { recursive: true }));

/** Runs a bundle and gives what it found. @param {string} path */
async function found(path) {
  globalThis.found = null;
  await import(pathToFileURL(path).href);

  for (let turn = 0; turn < 1000 && !globalThis.found; turn++) await new Promise((next) => setTimeout(next));
  return globalThis.found;
}

test("as it is installed it runs, without a build", async () => {
  assert.deepEqual(await found(join(folder, "main.js")), EXPECTED);
});

test("it installs into an empty project, with types", () => {
  const run = (command, ...parameters) =>
    execFileSync(command, parameters, { cwd: folder, encoding: "utf8", stdio: ["ignore", "pipe", "inherit"] });
  const { dependencies } = JSON.parse(readFileSync(join(folder, "node_modules/calibdb/package.json"), "utf8"));
  assert.equal(dependencies, undefined);
  assert.ok(existsSync(join(folder, "node_modules/calibdb/LICENSE")));
  writeFileSync(
    join(folder, "page.ts"),
    `import { lookup, rectifyPair, rig, type Calibration, type PairRectifier, type Pose, type View } from "calibdb";
    import { Bundle } from "calibdb/bundle"; import { applyCalibration } from "calibdb/adapters/babylon";
    import { Rectifier } from "calibdb/rectifier"; import { rectify } from "calibdb/stereo";
    const key = { camera: "x", platform: "y", img_size: [640, 480] as [number, number], zoom: 0 };
    const { calibration } = await lookup(key, { token: "t", model: "fisheye" });
    // @ts-expect-error a model is no number
    void lookup(key, { token: "t", model: 5 });
    export const known: Calibration | null = calibration;
    export const at: [number, number] | null | undefined = calibration?.project([0, 0, 1]);
    export const found = async (text: string) =>
      lookup(key, { bundle: new Bundle(JSON.parse(text)), token: text.length ? text : undefined });
    export type Eye = Parameters<typeof applyCalibration>[0];
    export const show = async (left: HTMLVideoElement, right: HTMLVideoElement, frame: VideoFrame) => {
      const known = await rig("id", { token: "t" });
      const pair: PairRectifier = await rectifyPair(left, right, known, { scale: 0.5, positions: [1, 2] });
      const pose: Pose = known.pose(1);
      const [first, second] = known.calibrations;
      document.body.append(pair.left, (await first.rectifier({ balance: 1 })).canvas, (await first.distorter()).canvas);
      const canvases: [OffscreenCanvas, OffscreenCanvas] = [new OffscreenCanvas(1, 1), new OffscreenCanvas(1, 1)];
      const options = { packing: "beside" as const, canvases };
      new Rectifier(first, { canvas: canvases[0] }).canvas.transferToImageBitmap();
      const away = await rectifyPair(frame, frame, { left: first, right: second, pose }, options);
      const eyes: View[] = [...known.toMetres(0.03).views({ near: 0.1 }), ...pair.views()];
      const seen = [pair.draw(), pair.depth(10), pair.point([1, 2], 3)[2], away.left.transferToImageBitmap()];
      return [...seen, eyes[0].transform.matrix, rectify(first, second, pose).Q];
    };`,
  );
  writeFileSync(
    join(folder, "worker.ts"),
    `import { lookup, type CameraKey } from "calibdb";
    onmessage = async ({ data }: MessageEvent<CameraKey>) =>
      postMessage((await lookup(data, { token: "t" })).calibration?.camera_matrix);`,
  );
  const strict = ["--ignoreConfig", "--noEmit", "--strict", "--exactOptionalPropertyTypes", "--skipLibCheck", "false"];
  const check = (files, resolution = "bundler", lib = "es2023,dom") => {
    const module = resolution === "bundler" ? "esnext" : resolution;
    const options = ["--target", "es2023", "--module", module, "--moduleResolution", resolution, "--lib", lib];
    run(`${root}node_modules/.bin/tsc`, ...files, ...strict, ...options);
  };
  for (const resolution of ["bundler", "node16"]) check(["page.ts"], resolution);
  check(["worker.ts"], "bundler", "es2023,webworker");
});

test("bundled by Vite it runs", async (t) => {
  if (missing) return t.skip(missing);
  const { build } = await import(pathToFileURL(createRequire(join(tools, "x.js")).resolve("vite")).href);
  await build({
    root: folder,
    logLevel: "error",
    build: {
      target: "es2022",
      modulePreload: { polyfill: false },
      rollupOptions: { output: { entryFileNames: "vite.js" } },
    },
  });
  assert.deepEqual(await found(join(folder, "dist/vite.js")), EXPECTED);
});

test("bundled by webpack it runs", async (t) => {
  if (missing) return t.skip(missing);
  const { default: webpack } = await import(pathToFileURL(createRequire(join(tools, "x.js")).resolve("webpack")).href);
  const stats = await new Promise((resolve, reject) =>
    webpack(
      {
        context: folder,
        mode: "production",
        entry: "./main.js",
        target: ["web", "es2022"],
        experiments: { outputModule: true },
        optimization: { minimize: false }, // Vite's bundle is minified
        output: { path: join(folder, "packed"), filename: "webpack.mjs", module: true, chunkFormat: "module" },
      },
      (error, result) => (error ? reject(error) : resolve(result)),
    ),
  );
  assert.deepEqual(stats.toJson({ all: false, errors: true, warnings: true }), { errors: [], warnings: [] });
  assert.deepEqual(await found(join(folder, "packed/webpack.mjs")), EXPECTED);
});
