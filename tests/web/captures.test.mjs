import assert from "node:assert/strict";
import { test } from "node:test";
import { Captures } from "../../web/calibrate/captures.js";
import { captureKey, viewCount } from "../../web/calibrate/state.js";
import { json, keepHere, setGlobals } from "./globals.mjs";
import { Sessions } from "./sessions.mjs";
import { ApiError, OfflineError } from "../../web/lib/api.js";
import { CaptureLoop } from "../../web/calibrate/capture-loop.js";
import { RequestQueue } from "../../web/calibrate/request-queue.js";
import { LICENCE_VERSION } from "../../web/lib/consent.js";
import { calibrate } from "../../web/lib/series.js";
import { CaptureSession, isUnavailable } from "../../web/lib/session.js";
import { isPracticeReturned } from "../../web/calibrate/history.js";
import { knownOf, knownText } from "../../web/calibrate/sender.js";
import "./messages.mjs";

const REQUEST = { camera: "c", platform: "p", img_size: [640, 480], zoom: 0, distortion_model: "rectilinear" };
const view = (id) => ({ ids: [id], points: [[id, id]] });
const VIEW = { set_aside: false };

async function begin() {
  const service = new Sessions();
  const capture = new CaptureSession(service.api, "token", REQUEST);
  await capture.start();
  return { service, capture };
}

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

test("an expired session begins again with the views it had", async () => {
  const { service, capture } = await begin();
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
  const { service, capture } = await begin();
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
  let sendings = 0;
  const capture = new CaptureSession(service.api, "token", REQUEST);
  capture.store(view(1));
  capture.store(view(2));
  capture.store(view(3));
  assert.equal(await capture.undo(), null);
  assert.equal(service.calls.length, 0);
  assert.deepEqual([capture.size, capture.waiting, capture.lastIsTaken], [2, 2, false]);
  const back = await capture.resume(undefined, { onSending: () => (sendings += 1) });
  assert.deepEqual([service.taken, back.taken, sendings, capture.lastIsTaken], [[[1, 2]], 2, 1, true]);
  const { credential, views } = capture.unsent();
  assert.equal(credential, "");
  assert.ok(views.every(({ index, taken }) => index === null && !taken));
  capture.track({ focusMode: "manual" });
  await capture.start();
  assert.deepEqual(service.calls.at(-1).body.track, { focusMode: "manual" });
});

test("the picture is asked for as JPEG, and a skip is asked for once", async () => {
  const { service, capture } = await begin();
  const { pose, picture } = await capture.pose({ skip: true });
  assert.deepEqual([pose.index, await picture.text()], [0, "picture"]);
  assert.deepEqual(
    service.calls.slice(2).map(({ call }) => call),
    ["GET /session/pose?skip=1", "GET /session/pose"],
  );
});

/** Answers the requests of a page. */
function serve(t) {
  const service = new Sessions();
  t.mock.method(globalThis, "fetch", async (address, request) =>
    String(address).endsWith("config.json")
      ? json(200, { api: "https://calibdb.example/v1", token: "t" })
      : service.fetch(address, request),
  );
  keepHere(t);
  return service;
}

for (const room of [true, false]) {
  const where = room ? "saved here" : "also if nothing can be saved";
  test(`a capture continues with the other views, ${where}`, async (t) => {
    const service = serve(t);
    const saved = new Map();
    const unsaved = [];
    const store = {
      load: async (about) => saved.get(about) ?? null,
      save: async (each) => room && Boolean(saved.set(each.about, each)),
      remove: async (about) => void saved.delete(about),
    };
    const captures = new Captures(store, { address: () => "?", onUnsaved: () => unsaved.push(1) });
    const run = { signal: new AbortController().signal, onRetry() {} };
    const { session } = await captures.open(REQUEST, run);
    for (const id of [1, 2, 3]) await session.submit(id - 1, view(id));
    const fisheye = { ...REQUEST, distortion_model: "fisheye" };
    await captures.move(session, fisheye, [1]);
    assert.deepEqual(
      [saved.has(captureKey(REQUEST)), saved.has(captureKey(fisheye)), unsaved.length > 0],
      [false, room, !room],
    );
    await captures.open(fisheye, run);
    await captures.forget(captureKey(fisheye));
    await captures.open(fisheye, run);
    assert.deepEqual(service.taken, [[1, 2, 3], [1, 3], []]);
  });
}

const FIRST_PAUSE_MS = 1_000;

/** The queue of a page in a state that does not change; `events`: what it hears. */
function queueOf(session, state, events) {
  const page = { state: () => state, fail: (error) => assert.fail(error) };
  const dispatch = (event) => events.push(event);
  const { signal } = new AbortController();
  return new RequestQueue(page, session, { dispatch, signal, onOffline() {}, async onOnline() {} });
}

/** An offline queue; each attempt to reconnect finds so many stored views, and may renew the session. */
function away(t, storedMeanwhile, renewals = 0) {
  const browser = new EventTarget(); // what a page hears of its network
  setGlobals(t, { addEventListener: browser.addEventListener.bind(browser) });
  t.mock.timers.enable({ apis: ["setTimeout"] });
  const [attempts, events] = [[], []];
  const session = {
    waiting: 1,
    renewals: 0,
    stored: () => session.waiting,
    async resume() {
      session.waiting = storedMeanwhile[attempts.length] ?? 0;
      attempts.push(session.waiting);
      session.renewals = renewals;
      return { state: { status: "capturing" }, taken: 1, refused: 0 };
    },
  };
  const state = { link: { busy: false, offline: true }, phase: "capturing", capture: {} };
  queueOf(session, state, events).goOffline();
  return { attempts, events, browser };
}

const settle = () => new Promise(setImmediate);

test("views that are stored while earlier ones are sent follow at once", async (t) => {
  const { attempts, events } = away(t, [2, 1, 0]);
  await settle();
  assert.deepEqual(attempts, []);
  t.mock.timers.tick(FIRST_PAUSE_MS);
  await settle();
  assert.deepEqual(attempts, [2, 1, 0]);
  assert.deepEqual(
    events.map(({ type, taken }) => [type, taken]),
    [["online", 3]],
  );
});

test("a network that is back is used at once, and a renewed session reported", async (t) => {
  const { attempts, events, browser } = away(t, [0], 1);
  browser.dispatchEvent(new Event("online"));
  await settle();
  assert.deepEqual(attempts, [0]);
  assert.deepEqual(
    events.map(({ type, notice }) => notice?.key ?? type),
    ["online", "capture.begun_anew"],
  );
});

/** Events of a page whose request finds the session in another state. */
async function heard(request) {
  const events = [];
  const session = { renewals: 0, resume: async () => ({ state: "as the service has it" }) };
  await queueOf(session, { link: { busy: false } }, events).send(
    () => request(session),
    () => {},
  );
  return events.map(({ type, session: state, notice }) => state ?? notice?.key ?? type);
}

test("a session renewed by a request is adopted and reported", async () => {
  const events = await heard(async (session) => (session.renewals += 1));
  assert.deepEqual(events, ["busy", "idle", "as the service has it", "capture.begun_anew"]);
});

test("a session that differs after a lost response is adopted", async () => {
  const events = await heard(() => Promise.reject(new ApiError(409, {})));
  assert.deepEqual(events, ["busy", "as the service has it", "idle"]);
});

/** A capture of whose views the page knows `views`. */
function looping(t, views) {
  setGlobals(t, { document: new EventTarget(), addEventListener() {} });
  const service = new Sessions();
  const state = {
    link: { busy: false, offline: false, stored: 0 },
    phase: "capturing",
    capture: { key: null, session: { views, calibration: {} } },
  };
  const settings = { focusMode: "continuous" };
  const session = new CaptureSession(service.api, "token", { ...REQUEST, track: { ...settings } });
  const parts = Object.fromEntries(["undo", "skip", "finish", "sharpest"].map((name) => [name, new EventTarget()]));
  const dispatch = ({ type }) => {
    if (type === "busy" || type === "idle") state.link.busy = type === "busy";
    if (type === "online") state.link.offline = false;
  };
  const page = { parts, state: () => state, dispatch, fail: (error) => assert.fail(error) };
  const stream = { camera: { track: { getSettings: () => settings } } };
  const detector = new Promise(() => {});
  const { signal } = new AbortController();
  const loop = new CaptureLoop(page, { session, detector, stream, plan: [], signal });
  return { loop, service, parts, settings, session, state };
}

test("a session without views begins again with the locked focus", async (t) => {
  for (const views of [[], [VIEW]]) {
    const { loop, service, settings, session } = looping(t, views);
    settings.focusMode = "manual";
    await loop.onFocused();
    const begun = service.bodies("POST /session").map(({ track }) => track.focusMode);
    assert.deepEqual(begun, views.length === 0 ? ["manual"] : []);
    assert.equal(service.bodies("GET /session/pose").length > 0, views.length === 0);
    assert.equal(session.request.track.focusMode, "manual");
  }
});

test("a finish during an outage follows once the service is back", async (t) => {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  const { loop, service, parts, state } = looping(t, Array(4).fill(VIEW));
  state.link.offline = true;
  parts.finish.dispatchEvent(new Event("click"));
  void loop.run();
  await settle();
  assert.deepEqual(service.calls, []);
  t.mock.timers.tick(FIRST_PAUSE_MS);
  const finishes = () => service.bodies("POST /session/finish").length;
  for (let turns = 0; turns < 100 && finishes() === 0; turns++) await settle();
  assert.equal(finishes(), 1);
});

test("no session says a licence unless the person agreed", async (t) => {
  keepHere(t);
  const { service } = await begin();
  await calibrate(service.api, "t", REQUEST, [], () => {});
  const bodies = service.bodies("POST /session");
  assert.equal(bodies.length, 2);
  assert.ok(bodies.every((body) => !("licence" in body) && !("licence_version" in body)));
});

test("consent to an earlier text is none to this one", async (t) => {
  const kept = keepHere(t);
  kept.set("calibdb.consent", "2020-01-01");
  const { hasConsent } = await import("../../web/lib/consent.js?earlier");
  assert.equal(hasConsent(), false);
  kept.set("calibdb.consent", LICENCE_VERSION);
  const { consentFields } = await import("../../web/lib/consent.js?later");
  assert.deepEqual(consentFields(), { licence: "CC0-1.0", licence_version: LICENCE_VERSION });
});

test("a running session is given its licence later", async (t) => {
  const kept = keepHere(t);
  const { service, capture } = await begin();
  kept.set("calibdb.consent", LICENCE_VERSION);
  await capture.license(service.api);
  assert.deepEqual(
    service.calls.map(({ call }) => call),
    ["POST /auth", "POST /session", "POST /session/licence"],
  );
});

const location = new URL("https://calibdb.example/calibrate/");
const VIRTUAL = "calibDB virtual camera 42e1b240";

test("only local applications get practice results unasked", (t) => {
  setGlobals(t, { location });
  assert.equal(isPracticeReturned("http://localhost:9000/app", "HD Pro Webcam C920"), true);
  assert.equal(isPracticeReturned("http://127.0.0.1:9000/", null), true);
  assert.equal(isPracticeReturned("https://app.example/", "HD Pro Webcam C920"), false);
  assert.equal(isPracticeReturned("https://localhost.app.example/", null), false);
  assert.equal(isPracticeReturned("https://app.example/", VIRTUAL), true);
  assert.equal(isPracticeReturned(null, null), false);
  assert.equal(isPracticeReturned("/ar/", null), false, "a page of this site is no application under development");
});

test("what a camera still needs is stated for the requested size", () => {
  const size = (img_size, agreeing, reliable = false) => ({
    img_size,
    calibrations: agreeing,
    agreeing,
    required: 5,
    reliable,
  });
  const answer = {
    cameras: [
      { camera: "HD Pro Webcam C920", sizes: [size([640, 480], 3), size([1280, 720], 9, true)] },
      { camera: "HD Pro Webcam C920 Plus", sizes: [size([640, 480], 4)] },
    ],
  };
  const said = (label, img_size) => knownText(knownOf(answer, label, img_size));
  assert.match(said("HD Pro Webcam C920 (046d:082d)", [640, 480]), /^2 more calibrations are needed/);
  assert.match(said("hd pro webcam c920", [1280, 720]), /knows this camera already/);
  assert.match(said("HD Pro Webcam C920", [1920, 1080]), /new here/);
  assert.match(said("Another", null), /new here/);
  const apart = { cameras: [{ camera: "C920", sizes: [size([640, 480], 6)] }] };
  assert.match(knownText(knownOf(apart, "C920", [640, 480])), /do not agree yet/);
  assert.equal(knownText(null), "");
});
