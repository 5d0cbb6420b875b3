import assert from "node:assert/strict";
import { createServer } from "node:http";
import { test } from "node:test";
import { isOffline, reach } from "../../web/lib/network.js";
import { Api, ApiError, OfflineError } from "../../web/lib/api.js";
import { CaptureSession, isUnavailable } from "../../web/lib/session.js";
import { viewCount } from "../../web/calibrate/state.js";
import { json } from "./globals.mjs";

const REQUEST = { camera: "c", platform: "p", img_size: [640, 480] };
const view = (id) => ({ ids: [id], points: [[id, id]] });

/** A service that answers from a list, and remembers what it was asked and how long it was waited for. */
function service(answers) {
  const calls = [];
  const waits = [];
  const api = new Api("/v1/", {
    fetch: async (address, { method, headers, body }) => {
      calls.push({
        call: `${method} ${address}`,
        credential: headers.authorization,
        accept: headers.accept,
        body: body && JSON.parse(body),
      });
      const answer = typeof answers === "function" ? answers(calls.at(-1)) : answers.shift();
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
  assert.equal(new Set(calls.map(({ body }) => JSON.stringify(body))).size, 1);
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
  await assert.rejects(api.json("GET", "/session", "sid"), OfflineError);
  assert.equal(calls.length, 1 + 8);
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
  const { api } = service(({ call }) => {
    if (call === "POST /v1/auth") return json(201, { session_id: "s", expires_at: 0 });
    return json(200, { index: 0, status: "capturing", accepted: true, views: [] });
  });
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
  const known = new Map();
  let sessions = 0;
  let index = 0;
  const { api, calls } = service(({ call, credential, body }) => {
    if (call === "POST /v1/auth") return json(201, { session_id: `s${++sessions}`, expires_at: 0 });
    const session = credential.replace("Bearer ", "");
    if (session === "s1" && known.get("expired"))
      return json(403, { type: "https://calibdb.example/problems/session-expired", detail: "expired" });
    if (call === "POST /v1/session") return json(201, { status: "capturing", views: [] });
    if (call === "GET /v1/session/pose") return json(200, { index });
    known.set(`${session} ${index++}`, body.ids);
    return json(200, { status: "capturing", accepted: true, reason: null, views: [] });
  });
  const capture = new CaptureSession(api, "token", REQUEST);
  await capture.start();
  await capture.submit(0, view(1));
  await capture.submit(1, view(2));
  known.set("expired", true);
  await capture.submit(2, view(3));
  assert.deepEqual(
    [...known].filter(([key]) => key.startsWith("s2")).map(([, ids]) => ids),
    [[1], [2], [3]],
  );
  assert.equal(calls.filter(({ call }) => call === "POST /v1/auth").length, 2);
});

test("a capture resumes with its views, also one whose answer was lost", async () => {
  const taken = new Map();
  let broken = false;
  const { api } = service(({ call, body }) => {
    if (call === "POST /v1/auth") return json(201, { session_id: "s", expires_at: 0 });
    if (call === "POST /v1/session/views") taken.set(body.index, body.ids);
    if (call.startsWith("DELETE")) taken.delete(Number(call.split("/").at(-1)));
    if (broken) return new OfflineError();
    return json(200, { accepted: true, status: "capturing", views: [...taken.keys()].map((index) => ({ index })) });
  });
  const capture = new CaptureSession(api, "token", REQUEST);
  await capture.start();
  await capture.submit(0, view(1));
  broken = true;
  await assert.rejects(capture.submit(1, view(2)), OfflineError);
  broken = false;
  assert.deepEqual((await capture.resume(api)).state.views, [{ index: 0 }, { index: 1 }]);
  await capture.undo();
  assert.deepEqual([...taken.keys()], [0], "the view whose answer was lost is the last one");
});

test("views taken during an outage are sent in order later", async () => {
  const taken = [];
  let away = false;
  let saved = null;
  const { api, calls } = service(({ call, body }) => {
    if (away) return json(503, {});
    if (call === "POST /v1/auth") return json(201, { session_id: "s", expires_at: 0 });
    if (call === "GET /v1/session/pose") return json(200, { index: taken.length });
    if (call !== "POST /v1/session/views")
      return json(200, { status: "capturing", views: taken.map((_, index) => ({ index })) });
    const accepted = body.ids[0] !== 3; // one of them brings nothing new
    if (accepted) taken.push(body.ids[0]);
    return json(200, { accepted, status: "capturing", views: taken.map((_, index) => ({ index })) });
  });
  const capture = new CaptureSession(api, "token", REQUEST, {
    about: "c",
    save: (now) => (saved = structuredClone(now)),
  });
  await capture.start();
  await capture.submit(0, view(1));
  away = true;
  const began = calls.length;
  await assert.rejects(capture.submit(1, view(2)), isUnavailable);
  assert.equal(calls.length - began, 3, "a timeout of two seconds: the page has better to do than to wait");
  capture.store(view(3));
  capture.store(view(4));
  assert.equal(capture.waiting, 3);
  assert.equal(viewCount({ capture: { session: { views: [{ index: 0 }] } }, link: { stored: capture.waiting } }), 4);
  await assert.rejects(capture.resume(), isUnavailable);
  away = false;
  const next = new CaptureSession(api, "token", REQUEST, { about: "c", saved });
  const { state, refused } = await next.resume();
  assert.deepEqual([taken, refused, state.views.length, next.waiting], [[1, 2, 4], 1, 3, 0]);
});

test("a capture begun offline is sent later", async () => {
  const taken = [];
  const { api, calls } = service(({ call, body }) => {
    if (call === "POST /v1/auth") return json(201, { session_id: "s", expires_at: 0 });
    if (call === "GET /v1/session/pose") return json(200, { index: taken.length });
    if (call === "POST /v1/session/views") taken.push(body.ids[0]);
    return json(200, { accepted: true, status: "capturing", views: taken.map((_, index) => ({ index })) });
  });
  let told = 0;
  const capture = new CaptureSession(api, "token", REQUEST);
  capture.store(view(1));
  capture.store(view(2));
  assert.deepEqual([capture.size, capture.waiting, capture.lastIsTaken], [2, 2, false]);
  const back = await capture.resume(undefined, { onSending: () => (told += 1) });
  assert.deepEqual(
    [calls[0].call, taken, back.taken, told, capture.lastIsTaken],
    ["POST /v1/auth", [1, 2], 2, 1, true],
  );
  const { credential, views } = capture.unsent();
  assert.deepEqual(
    [credential, views.map(({ index, taken: sent }) => [index, sent])],
    [
      "",
      [
        [null, false],
        [null, false],
      ],
    ],
  );
  capture.track({ focusMode: "manual" });
  await capture.start();
  assert.deepEqual(calls.at(-1).body.track, { focusMode: "manual" });
});

test("a view not yet sent is taken back without the service", async () => {
  const { api, calls } = service(() => json(200, {}));
  const capture = new CaptureSession(api, "token", REQUEST);
  capture.store(view(1));
  assert.equal(await capture.undo(), null);
  assert.deepEqual([calls.length, capture.waiting], [0, 0]);
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
  const { api, calls } = service(({ accept }) =>
    accept === "image/jpeg" ? new Response("picture", { status: 200 }) : json(200, { index: 4 }),
  );
  const capture = new CaptureSession(api, "token", REQUEST);
  const { pose, picture } = await capture.pose({ skip: true });
  assert.deepEqual([pose.index, await picture.text()], [4, "picture"]);
  assert.deepEqual(
    calls.map(({ call }) => call),
    ["GET /v1/session/pose?skip=1", "GET /v1/session/pose"],
  );
});
