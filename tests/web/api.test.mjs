import assert from "node:assert/strict";
import { test } from "node:test";
import { isOffline, reach } from "../../web/lib/network.js";
import { Api, ApiError, OfflineError } from "../../web/lib/api.js";
import { inTurn, json, setGlobals } from "./globals.mjs";

/** A service that answers from a list, and remembers what it was asked and how long it was waited for. */
function service(answers, transport = {}) {
  const calls = [];
  const waits = [];
  const api = new Api("/v1/", {
    fetch: async (_, { body }) => {
      calls.push(body);
      return inTurn(answers);
    },
    wait: async (ms) => void waits.push(ms),
    ...transport,
  });
  return { api, calls, waits };
}

const get = (api, options) => api.json("GET", "/session", "sid", options);

test("a lost network and a busy service are retried", async () => {
  const { api, calls, waits } = service([
    new OfflineError(),
    json(503, {}),
    json(429, {}, { "retry-after": "3" }),
    json(200, { views: [] }),
  ]);
  assert.deepEqual(await api.json("POST", "/session/views", "sid", { body: { index: 1 } }), { views: [] });
  assert.equal(new Set(calls).size, 1);
  assert.deepEqual(waits, [500, 1000, 3000]);
});

test("an hour that is used up is said at once", async () => {
  const { api, calls, waits } = service([
    json(429, { detail: "The calls of this hour are used up." }, { "retry-after": "1800" }),
  ]);
  await assert.rejects(
    api.json("POST", "/auth", "token"),
    (error) =>
      error instanceof ApiError && error.status === 429 && error.message === "The calls of this hour are used up.",
  );
  assert.deepEqual([calls.length, waits], [1, []]);
});

test("retries end after a minute", async () => {
  const { api, waits } = service([new OfflineError(true)]);
  await assert.rejects(get(api), OfflineError);
  assert.equal(
    waits.reduce((sum, ms) => sum + ms),
    60_500,
  );
});

test("a refusal is said in the service's words and not repeated", async () => {
  const { api, calls } = service([
    json(422, { detail: "The request is not valid.", errors: [{ field: "img_size", detail: "too small" }] }),
  ]);
  await assert.rejects(
    api.json("POST", "/session", "sid", { body: {} }),
    (error) =>
      error instanceof ApiError &&
      error.status === 422 &&
      error.message === "The request is not valid. img_size: too small",
  );
  assert.equal(calls.length, 1);
});

test("whoever gets through ends the waiting, also of a call that gave up", async () => {
  const retries = [];
  const lost = new OfflineError();
  const { api } = service([lost, lost, lost, json(200, {}), json(200, {})], {
    onRetry: (now) => retries.push(now?.attempt ?? 0),
  });
  await assert.rejects(get(api, { brief: true }), OfflineError);
  await get(api, { brief: true });
  await get(api, { brief: true });
  assert.deepEqual(retries, [1, 2, 0]);
});

test("a brief call gives up a silent server after one wait", async () => {
  const { api, calls } = service([new OfflineError(true)]);
  await assert.rejects(get(api, { brief: true }), OfflineError);
  assert.equal(calls.length, 1);
});

/** A `fetch` that never ends but by its signal: nothing comes, or, of `/half`, only the headers. */
function silentFetch(address, { signal }) {
  return new Promise((answer, reject) => {
    const end = (fail) =>
      signal.aborted ? fail(signal.reason) : signal.addEventListener("abort", () => fail(signal.reason));
    if (!address.endsWith("/half")) end(reject);
    else answer(new Response(new ReadableStream({ start: (body) => end((reason) => body.error(reason)) })));
  });
}

test("a silent server is offline", async (t) => {
  setGlobals(t, { fetch: silentFetch });
  const alive = setInterval(() => {}, 1000); // node does not wait for the timer of a signal
  t.after(() => clearInterval(alive));
  const api = new Api("https://silent.example", { timeout: 50 });
  await assert.rejects(api.json("GET", "/none", "sid", { brief: true }), OfflineError);
  await assert.rejects(api.json("GET", "/half", "sid", { brief: true }), OfflineError);
  const aborted = { signal: AbortSignal.abort() };
  await assert.rejects(reach("https://silent.example/none", aborted), { name: "AbortError" });
});

test("a programming error is not a lost network", async () => {
  const { api } = service([new RangeError("ours")]);
  await assert.rejects(get(api), RangeError);
});

test("a module that did not arrive is a lost network", () => {
  for (const message of [
    "Failed to fetch dynamically imported module: http://localhost/lib/camera.js", // Chromium
    "error loading dynamically imported module: http://localhost/lib/camera.js", // Firefox
    "Importing a module script failed.", // WebKit
  ])
    assert.ok(isOffline(new TypeError(message)), message);
  assert.ok(isOffline(new OfflineError()));
  assert.ok(!isOffline(new TypeError("undefined is not a function")));
});

test("nothing more is asked once the run has ended", async () => {
  const run = new AbortController();
  const { api, calls } = service([new OfflineError()], { wait: async () => run.abort(), signal: run.signal });
  await assert.rejects(get(api), { name: "AbortError" });
  assert.equal(calls.length, 1);
});
