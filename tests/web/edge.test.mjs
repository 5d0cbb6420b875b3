import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { LookupError, lookup } from "../../web/sdk/calibdb.js";
import { edgeAddress } from "../../web/sdk/edge.js";

const KEY = { camera: "HD Pro Webcam C920 (046d:082d)", platform: "X11; Linux x86_64", img_size: [1280, 720], zoom: 0 };
const KNOWN = {
  img_size: [1280, 720],
  camera_matrix: [
    [1000, 0, 640],
    [0, 1000, 360],
    [0, 0, 1],
  ],
  distortion_coefficients: [0, 0, 0, 0, 0],
  distortion_model: "rectilinear",
  reliable: true,
  exact_size: true,
  spread: 0.2,
  uncertainty: { rms: 0.3, max: 0.9 },
};
const MISS = { status: 404, guidance_url: "https://calibdb.example/calibrate/?camera=x", reason: "too_few" };
const json = (status, body) =>
  new Response(JSON.stringify(body), { status, headers: { "content-type": "application/json" } });
let sites = 0;
/** A site of its own, whose edge, service and settings answer as told, and what was asked of it. */
function site({ edge = () => json(404, { reason: "unknown_camera" }), service = () => json(404, MISS) }) {
  const asked = [];
  const fetch = async (address, request = {}) => {
    const { pathname } = new URL(address);
    asked.push({ pathname, request });
    return await (pathname.startsWith("/known/") ? edge : service)(request);
  };
  const api = `https://site${++sites}.example/v1`;
  return {
    asked,
    paths: () => asked.map(({ pathname }) => pathname.replace(/[0-9a-f]{32}/, "*")),
    options: { token: "cdb_a_b", api, cache: null, fetch, pause: async () => {} },
  };
}

test("the address of an answer is the digest that docs/api.md prints", async () => {
  const text = readFileSync(new URL("../../docs/api.md", import.meta.url), "utf8");
  const rows = [
    ...text.matchAll(/^\| `(.+?)` \| `(.+?)` \| (\d+)x(\d+) \| ([\d.]+) \| (\w+) \| `(\/known\/\S+)` \|$/gm),
  ];
  assert.ok(rows.length >= 3, "test vectors");
  for (const [, camera, platform, width, height, zoom, model, path] of rows) {
    const key = { camera, platform, img_size: [Number(width), Number(height)], zoom: Number(zoom) };
    const { href } = await edgeAddress(key, model, "https://calibdb.example/v1/");
    assert.equal(href, `https://calibdb.example${path}`);
    const spelt = { ...key, camera: ` ${camera.normalize("NFD")}\t` };
    assert.equal((await edgeAddress(spelt, model, "https://calibdb.example/v1")).href, href);
  }
  assert.equal(
    await edgeAddress({ ...KEY, resize_mode: "crop-and-scale" }, "rectilinear", "https://calibdb.example/v1"),
    null,
  );
  assert.equal(
    await edgeAddress({ ...KEY, zoom: 0.0078125 }, "rectilinear", "https://calibdb.example/v1"),
    null,
    "more than six decimals",
  );
});

test("a known camera is one GET without headers, and nothing else", async () => {
  const { asked, paths, options } = site({ edge: () => json(200, KNOWN), service: () => json(500, {}) });
  const { calibration } = await lookup(KEY, options);
  assert.deepEqual(JSON.parse(JSON.stringify(calibration)), KNOWN);
  assert.deepEqual(paths(), ["/known/v1/*/1280x720/0/rectilinear.json"]);
  const [
    {
      request: { method = "GET", headers, credentials },
    },
  ] = asked;
  assert.deepEqual(
    [method, headers, credentials],
    ["GET", undefined, "omit"],
    "what a browser sends without asking first",
  );
});

test("an unknown camera is asked of the service, and of the edge once an hour and tab", async () => {
  const kept = new Map();
  const cache = { getItem: (name) => kept.get(name) ?? null, setItem: (name, value) => void kept.set(name, value) };
  const { paths, options } = site({});
  const path = "/known/v1/*/1280x720/0/rectilinear.json";
  for (let n = 0; n < 3; n++) assert.equal((await lookup(KEY, { ...options, cache })).reason, "too_few");
  assert.deepEqual(paths(), [path, "/v1/lookup", "/v1/lookup", "/v1/lookup"]);
  const [name] = [...kept].find(([, value]) => Math.abs(Number(value) - Date.now()) < 60_000);
  kept.set(name, String(Date.now() - 3_600_001));
  await lookup(KEY, { ...options, cache });
  await lookup({ ...KEY, zoom: 2 }, { ...options, cache });
  assert.deepEqual(paths().slice(4), [path, "/v1/lookup", "/known/v1/*/1280x720/2/rectilinear.json", "/v1/lookup"]);
  const full = {
    getItem: () => null,
    setItem: () => {
      throw new DOMException("full", "QuotaExceededError");
    },
  };
  assert.equal((await lookup(KEY, { ...options, cache: full })).reason, "too_few");
});

test("while every function fails, a known camera has its answer, and another camera a reason", async () => {
  for (const failing of [
    () => json(503, { detail: "Service Unavailable" }),
    () => {
      throw new TypeError("fetch failed");
    },
  ]) {
    const known = site({ edge: () => json(200, KNOWN), service: failing });
    assert.ok((await lookup(KEY, known.options)).calibration);
    const unknown = site({ service: failing });
    await assert.rejects(
      lookup(KEY, unknown.options),
      (error) =>
        error instanceof LookupError && /cannot be asked now/.test(error.message) && error.cause instanceof LookupError,
    );
  }
  const forbidden = site({ service: () => json(403, { detail: "The API token is not valid." }) });
  await assert.rejects(lookup(KEY, forbidden.options), { status: 403, message: "The API token is not valid." });
});

test("an edge that fails, or answers with something else, is no obstacle", async () => {
  const failures = [
    () => {
      throw new TypeError("CORS");
    },
    () => json(500, {}),
    () => json(200, {}),
    () => new Response("<h1>hello</h1>"),
    () => new Response("{", { headers: { "content-type": "application/json" } }),
  ];
  for (const edge of failures) {
    const { options } = site({ edge, service: () => json(200, KNOWN) });
    assert.ok((await lookup(KEY, options)).calibration);
  }
});

test("a slow edge is overtaken by the service, and a slow service by the edge", async () => {
  const never = ({ signal }) =>
    new Promise((_, reject) => {
      if (signal?.aborted) reject(signal.reason);
      signal?.addEventListener("abort", () => reject(signal.reason));
    });
  const stuck = site({ edge: never, service: () => json(200, KNOWN) });
  assert.ok((await lookup(KEY, stuck.options)).calibration);
  let asked = () => {};
  const service = new Promise((resolve) => {
    asked = resolve;
  });
  const late = site({
    edge: async () => {
      await service;
      return json(200, KNOWN);
    },
    service: (request) => {
      asked();
      return never(request);
    },
  });
  assert.ok((await lookup(KEY, late.options)).calibration);
  const given = new AbortController();
  const up = site({
    edge: (request) => {
      given.abort(new Error("enough"));
      return never(request);
    },
  });
  await assert.rejects(lookup(KEY, { ...up.options, signal: given.signal }), /enough/);
});
