import assert from "node:assert/strict";
import { createServer } from "node:http";
import { test } from "node:test";
import { isOffline, reach } from "../../web/lib/network.js";
import { Api, ApiError, OfflineError } from "../../web/lib/api.js";
import { CaptureSession, isUnavailable } from "../../web/lib/session.js";
import { viewCount } from "../../web/calibrate/state.js";
import { json } from "./globals.mjs";
import { Sessions } from "./sessions.mjs";

const REQUEST = { camera: "c", platform: "p", img_size: [640, 480] };
const view = (id) => ({ ids: [id], points: [[id, id]] });

/** A service that answers from a list, and remembers what it was asked and how long it was waited for. */
function service(answers) {
  const calls = [];
  const waits = [];
  const api = new Api("/v1/", {
    fetch: async (_, { body }) => {
      calls.push(body);
      const answer = typeof answers === "function" ? answers() : answers.shift();
      if (answer instanceof Error) throw answer;
      return answer;
    },
    wait: async (ms) => void waits.push(ms),
  });
  return { api, calls, waits };
}

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
  const { api, waits } = service(() => new OfflineError());
  await assert.rejects(api.json("GET", "/session", "sid"), OfflineError);
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
  const answers = [new OfflineError(), new OfflineError(), new OfflineError(), json(200, {}), json(200, {})];
  const fetch = async () => {
    const answer = answers.shift();
    if (answer instanceof Error) throw answer;
    return answer;
  };
  const api = new Api("/v1", { fetch, wait: async () => {}, onRetry: (now) => retries.push(now?.attempt ?? 0) });
  await assert.rejects(api.json("GET", "/session", "sid", { brief: true }), OfflineError);
  await api.json("GET", "/session", "sid", { brief: true });
  await api.json("GET", "/session", "sid", { brief: true });
  assert.deepEqual(retries, [1, 2, 0]);
});

test("a brief call gives up a silent server after one wait", async () => {
  const { api, calls } = service(() => new OfflineError(true));
  await assert.rejects(api.json("GET", "/session", "sid", { brief: true }), OfflineError);
  assert.equal(calls.length, 1);
});

test("a silent server is offline", async () => {
  const server = createServer((request, response) => {
    if (request.url === "/half") response.writeHead(200, { "content-length": 10 }).write("half");
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  const address = `http://127.0.0.1:${server.address().port}`;
  const api = new Api(address, { timeout: 50 });
  await assert.rejects(api.json("GET", "/none", "sid", { brief: true }), OfflineError);
  await assert.rejects(api.json("GET", "/half", "sid", { brief: true }), OfflineError);
  await assert.rejects(reach(`${address}/none`, { signal: AbortSignal.abort() }), { name: "AbortError" });
  server.closeAllConnections();
  server.close();
});

test("a programming error is not a lost network", async () => {
  const { api } = service([new RangeError("ours")]);
  await assert.rejects(api.json("GET", "/session", "sid"), RangeError);
});

test("first requests are reported by kind", async () => {
  const answered = new Set();
  const { api } = new Sessions();
  const asked = [];
  for (const expected of [
    [true, true, true, false, true, false, true, false],
    [false, false, false, false, false, false, false, false],
  ]) {
    const capture = new CaptureSession(api, "token", REQUEST, { answered });
    capture.onRequest = (isFirst) => asked.push(isFirst);
    await capture.start();
    await capture.pose(); // as numbers and as a picture
    for (const index of [0, 1]) await capture.submit(index, view(index));
    for (const _ of [0, 1]) await capture.undo();
    assert.deepEqual(asked.splice(0), expected);
  }
});

test("an expired session is begun anew with the views it had", async () => {
  const service = new Sessions();
  const capture = new CaptureSession(service.api, "token", REQUEST);
  await capture.start();
  await capture.submit(0, view(1));
  await capture.submit(1, view(2));
  service.expired = 1;
  await capture.submit(2, view(3));
  assert.deepEqual(service.taken, [
    [1, 2],
    [1, 2, 3],
  ]);
});

test("a capture resumes with its views, also one whose answer was lost", async () => {
  const service = new Sessions();
  const capture = new CaptureSession(service.api, "token", REQUEST);
  await capture.start();
  await capture.submit(0, view(1));
  service.isLosing = true;
  await assert.rejects(capture.submit(1, view(2)), OfflineError);
  service.isLosing = false;
  assert.deepEqual((await capture.resume(service.api)).state.views, [{ index: 0 }, { index: 1 }]);
  await capture.undo();
  assert.deepEqual(service.taken, [[1]], "the view whose answer was lost is the last one");
});

test("views taken during an outage are sent in order later", async () => {
  let saved = null;
  const service = new Sessions();
  service.judge = (id) => (id === 3 ? "no_information" : null);
  const capture = new CaptureSession(service.api, "token", REQUEST, {
    about: "c",
    save: (now) => (saved = structuredClone(now)),
  });
  await capture.start();
  await capture.submit(0, view(1));
  service.isAway = true;
  const began = service.calls.length;
  await assert.rejects(capture.submit(1, view(2)), isUnavailable);
  assert.equal(service.calls.length - began, 3, "a timeout of two seconds: the page has better to do than to wait");
  capture.store(view(3));
  capture.store(view(4));
  assert.equal(capture.waiting, 3);
  assert.equal(viewCount({ capture: { session: { views: [{ index: 0 }] } }, link: { stored: capture.waiting } }), 4);
  await assert.rejects(capture.resume(), isUnavailable);
  service.isAway = false;
  const next = new CaptureSession(service.api, "token", REQUEST, { about: "c", saved });
  const { state, refused } = await next.resume();
  assert.deepEqual([service.taken, refused, state.views.length, next.waiting], [[[1, 2, 4]], 1, 3, 0]);
});

test("a capture begun offline is sent later", async () => {
  const service = new Sessions();
  let told = 0;
  const capture = new CaptureSession(service.api, "token", REQUEST);
  capture.store(view(1));
  capture.store(view(2));
  capture.store(view(3));
  assert.equal(await capture.undo(), null);
  assert.equal(service.calls.length, 0);
  assert.deepEqual([capture.size, capture.waiting, capture.lastIsTaken], [2, 2, false]);
  const back = await capture.resume(undefined, { onSending: () => (told += 1) });
  assert.deepEqual([service.taken, back.taken, told, capture.lastIsTaken], [[[1, 2]], 2, 1, true]);
  const { credential, views } = capture.unsent();
  assert.equal(credential, "");
  assert.ok(views.every(({ index, taken }) => index === null && !taken));
  capture.track({ focusMode: "manual" });
  await capture.start();
  assert.deepEqual(service.calls.at(-1).body.track, { focusMode: "manual" });
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
  let asked = 0;
  const api = new Api("/v1", {
    fetch: async () => {
      asked += 1;
      throw new OfflineError();
    },
    wait: async () => run.abort(),
    signal: run.signal,
  });
  await assert.rejects(api.json("GET", "/session", "sid"), { name: "AbortError" });
  assert.equal(asked, 1);
});

test("the picture is asked for as JPEG, and a skip is asked for once", async () => {
  const { api, calls } = new Sessions();
  const capture = new CaptureSession(api, "token", REQUEST);
  await capture.start();
  const { pose, picture } = await capture.pose({ skip: true });
  assert.deepEqual([pose.index, await picture.text()], [0, "picture"]);
  assert.deepEqual(
    calls.slice(2).map(({ call }) => call),
    ["GET /session/pose?skip=1", "GET /session/pose"],
  );
});
