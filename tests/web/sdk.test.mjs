import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { Api } from "../../web/lib/api.js";
import {
  Calibration,
  Estimate,
  LookupError,
  calibrate,
  cameraKey,
  lookup,
  platformHere,
  platformOf,
  returned,
  watch,
} from "../../web/sdk/calibdb.js";
import { edgeAddress } from "../../web/sdk/edge.js";
import { Bundle } from "../../web/sdk/bundle.js";
import { FULL, inTurn, json, setGlobals, storageOf } from "./globals.mjs";
import { calibrationOf, cameraMatrix } from "./scenes.mjs";

const KEY = { camera: "C920 (046d:082d)", platform: "X11; Linux x86_64", img_size: [1280, 720], zoom: 0 };
const KNOWN = {
  ...calibrationOf([1000], [640, 360]),
  reliable: true,
  exact_size: true,
  spread: 0.2,
  uncertainty: { rms: 0.3, max: 0.9 },
};
const MISS = { status: 404, guidance_url: "https://calibdb.example/calibrate/?camera=x", reason: "too_few" };
const LIKELY = { ...calibrationOf([920], [639.5, 359.5]), basis: "published" };
const API = "https://calibdb.example/v1";

/**
 * A service that gives one answer after the other, the last again and again, and its edge. `all`: what both were
 * asked; `asked`: the service.
 */
function site(edge, ...answers) {
  const [all, asked, waits] = [[], [], []];
  const fetch = async (address, request = {}) => {
    const { href, pathname } = new URL(address);
    all.push({ path: pathname.replace(/[0-9a-f]{32}/, "*"), request });
    if (pathname.includes("/known/")) return edge(request);
    asked.push({ address: href, ...request, body: request.body && JSON.parse(request.body) });
    const answer = inTurn(answers);
    return (typeof answer === "function" ? await answer(request) : answer).clone();
  };
  const pause = async (milliseconds) => void waits.push(milliseconds);
  return { all, asked, waits, options: { token: "cdb_a_b", api: API, cache: null, fetch, pause } };
}
const unknown = () => json(404, { reason: "unknown_camera" });
const unreachable = () => {
  throw new TypeError("fetch failed");
};
/** Answers nothing until it is cancelled. */
const never = ({ signal }) =>
  new Promise((_, reject) => {
    if (signal?.aborted) reject(signal.reason);
    signal?.addEventListener("abort", () => reject(signal.reason));
  });
/** A service whose edge knows nothing. */
const service = (...answers) => site(unknown, ...answers);
const plain = (data) => JSON.parse(JSON.stringify(data));
/** A lookup at a service with one answer. */
const found = (answer, options = {}) => lookup(KEY, { ...service(answer).options, ...options });
function camera(settings) {
  const track = Object.assign(new EventTarget(), { kind: "video", readyState: "live", label: "FaceTime HD", settings });
  return Object.assign(track, { getSettings: () => track.settings });
}

test("a known camera is answered with its calibration", async () => {
  const { asked, options } = service(json(200, KNOWN));
  const { calibration, guidanceUrl, reason } = await lookup(KEY, { ...options, model: "fisheye" });
  assert.ok(calibration instanceof Calibration);
  assert.deepEqual(plain(calibration), KNOWN);
  assert.deepEqual([guidanceUrl, reason], [null, null]);
  const [{ address, method, headers, body }] = asked;
  assert.deepEqual([address, method, headers.authorization], [`${API}/lookup`, "POST", "Bearer cdb_a_b"]);
  assert.deepEqual(body, { ...KEY, distortion_model: "fisheye", redirect: false, miss: "ok" });
});

test("an estimate is the camera only if it is accepted", async () => {
  const miss = json(200, { calibration: null, ...MISS, estimate: LIKELY });
  const cautious = await found(miss);
  assert.ok(cautious.estimate instanceof Estimate && !(cautious.estimate instanceof Calibration));
  assert.deepEqual(plain(cautious.estimate), LIKELY);
  assert.deepEqual([cautious.calibration, cautious.camera], [null, null]);
  const { calibration, camera, guidanceUrl } = await found(miss, { accept: "estimate" });
  assert.deepEqual([calibration, guidanceUrl], [null, MISS.guidance_url]);
  assert.ok(camera instanceof Estimate);
  assert.deepEqual(camera.project([0, 0, 1]), [639.5, 359.5]);
  const known = await found(json(200, KNOWN), { accept: "estimate" });
  assert.equal(known.camera, known.calibration);
});

test("a phone's model is part of the camera's key", async () => {
  const { asked, options } = service(json(200, KNOWN));
  const phone = { ...KEY, camera: "Back Camera", platform: "iPhone; CPU iPhone OS 17_5 like Mac OS X" };
  await lookup(phone, { ...options, device: "iPhone14,5" });
  await lookup({ ...phone, platform: `${phone.platform}; iPhone14,5` }, { ...options, device: "iPhone14,5" });
  const platforms = asked.map(({ body }) => body.platform);
  assert.deepEqual(platforms, Array(2).fill("iPhone; CPU iPhone OS 17_5 like Mac OS X; iPhone14,5"));
});

test("views and their board are sent with a lookup", async () => {
  const likely = { ...LIKELY, basis: "views", group: "78°" };
  const { asked, options } = service(json(200, { calibration: null, ...MISS, estimate: likely }));
  const seen = { views: [{ ids: [0], points: [[10, 20]] }], board: { squares: [9, 6] } };
  const { estimate } = await lookup(KEY, { ...options, ...seen });
  assert.deepEqual([asked[0].body.views, asked[0].body.board], [seen.views, seen.board]);
  assert.equal(estimate.group, "78°");
  await lookup(KEY, options);
  assert.ok(!("views" in asked[1].body));
});

test("an unknown camera calls onNeedCalibration with an address", async () => {
  for (const miss of [json(404, MISS), json(200, { calibration: null, ...MISS })]) {
    const { asked, options } = service(miss);
    const reported = [];
    const answer = await lookup(KEY, { ...options, api: `${API}/`, onNeedCalibration: (each) => reported.push(each) });
    const nothing = { calibration: null, estimate: null, camera: null };
    assert.deepEqual(answer, { ...nothing, guidanceUrl: MISS.guidance_url, reason: "too_few" });
    assert.deepEqual(reported, [answer]);
    assert.equal(asked[0].address, `${API}/lookup`);
  }
});

test("anything else is an error with its status and the service's words", async () => {
  await assert.rejects(
    found(json(403, { detail: "The API token is not valid." })),
    (error) => error instanceof LookupError && error.status === 403 && /token/.test(error.message),
  );
  await assert.rejects(found(new Response("<h1>Bad gateway</h1>", { status: 502 })), { status: 502 });
  await assert.rejects(
    lookup(KEY, site(unreachable, unreachable).options),
    (error) => error.status === 0 && /cannot be reached/.test(error.message) && error.cause instanceof TypeError,
  );
});

test("passing failures are retried with growing pauses", async () => {
  const { waits, options } = service(
    new TypeError("no network"),
    json(503, {}),
    json(429, {}, { "retry-after": "5" }),
    json(200, KNOWN),
  );
  assert.ok((await lookup(KEY, options)).calibration);
  assert.ok(waits[0] >= 250 && waits[0] <= 500 && waits[1] >= 500 && waits[1] <= 1000 && waits[2] === 5000, `${waits}`);
  const spent = service(json(429, { detail: "The plan's calls are used up." }, { "retry-after": "1800" }));
  await assert.rejects(lookup(KEY, spent.options), { status: 429 });
  assert.equal(spent.asked.length, 1, "nobody waits for half an hour");
});

test("SDK and pages ask again after the same answers", async () => {
  for (const status of [404, 409, 413, 429, 500, 501, 502, 503, 504]) {
    const [sdk, page] = [0, 1].map(() => service(json(status, {})));
    await assert.rejects(lookup(KEY, sdk.options), { status });
    const { fetch, pause: wait } = page.options;
    await assert.rejects(new Api(API, { fetch, wait }).send("GET", "/cameras", "cdb_a_b"), { status });
    const expected = [429, 500, 502, 503, 504].includes(status) ? [4, 8] : [1, 1];
    assert.deepEqual([sdk.asked.length, page.asked.length], expected, `${status}`);
  }
});

test("a broken answer is retried, and another service's is not taken", async () => {
  const broken = new Response('{"img_size": [', { headers: { "content-type": "application/json" } });
  const { asked, options } = service(broken, json(200, KNOWN));
  assert.ok((await lookup(KEY, options)).calibration);
  assert.equal(asked.length, 2);
  await assert.rejects(
    found(broken),
    ({ status, cause }) => status === 0 && cause.status === 0 && cause.cause instanceof SyntaxError,
  );
  const kept = new Map();
  for (const other of [
    new Response("<!doctype html>Log in to this network", { headers: { "content-type": "text/html" } }),
    json(200, {}),
  ]) {
    await assert.rejects(
      found(other, { cache: storageOf(kept) }),
      (error) => error instanceof LookupError && /is not calibDB/.test(error.message),
    );
  }
  assert.ok([...kept.keys()].every((name) => name.endsWith(" missed")));
});

test("what was forgotten is said", async (t) => {
  const {
    asked,
    options: { api: _, ...options },
  } = service(json(404, MISS));
  await assert.rejects(lookup(KEY, options), /say where it is: { api }/, "these files came from a disk");
  await assert.rejects(lookup(KEY), /API token: { token }/);
  await assert.rejects(lookup(undefined, options), /there is no camera/);
  setGlobals(t, { location: { href: "https://app.example/ar/" } });
  await lookup(KEY, { ...options, api: "/calibdb/v1" });
  assert.equal(asked[0].address, "https://app.example/calibdb/v1/lookup");
});

test("it stops when it is told to, on the line and between attempts", async () => {
  const controller = new AbortController();
  const running = found(never, { signal: controller.signal });
  setTimeout(() => controller.abort(), 5);
  await assert.rejects(running, { name: "AbortError" });
  const late = new AbortController();
  const {
    asked,
    options: { pause: _, ...options },
  } = service(() => {
    setTimeout(() => late.abort(new DOMException("late", "TimeoutError")), 5);
    return json(503, {});
  });
  await assert.rejects(lookup(KEY, { ...options, signal: late.signal }), { name: "TimeoutError" });
  assert.equal(asked.length, 1);
  const cache = storageOf(new Map());
  await found(json(200, KNOWN), { cache });
  await assert.rejects(lookup(KEY, { ...options, cache, signal: AbortSignal.abort() }), { name: "AbortError" });
});

test("a known camera is looked up once per tab", async () => {
  const cache = storageOf(new Map());
  const estimate = json(200, { calibration: null, ...MISS, estimate: LIKELY });
  const { asked, options } = service(estimate, json(200, KNOWN));
  assert.equal((await lookup(KEY, { ...options, cache, accept: "estimate" })).calibration, null);
  assert.ok((await lookup(KEY, { ...options, cache })).calibration);
  assert.ok((await lookup(KEY, { ...options, cache })).calibration instanceof Calibration);
  assert.equal(asked.length, 2);
  await lookup({ ...KEY, img_size: [640, 480] }, { ...options, cache });
  await lookup(KEY, { ...options, cache, model: "fisheye" });
  await lookup(KEY, { ...options, cache, api: "https://other.example/v1" });
  assert.equal(asked.length, 5, "another size, model or service is another question");
  const damaged = { getItem: () => '{"camera_mat', setItem() {} };
  assert.ok((await lookup(KEY, { ...options, cache: damaged })).calibration);
  assert.ok((await lookup(KEY, { ...options, cache: FULL })).calibration);
});

test("an unmet wish leads to the guidance page", async () => {
  const other = { ...KNOWN, exact_size: false };
  const answer = await found(json(200, other), { exact: true });
  assert.deepEqual([answer.calibration, answer.reason], [null, "other_size"]);
  const { camera, platform } = KEY;
  const query = { camera, platform, img_size: "1280x720", zoom: 0, distortion_model: "rectilinear" };
  assert.equal(answer.guidanceUrl, `https://calibdb.example/calibrate/?${new URLSearchParams(query)}`);
  assert.ok((await found(json(200, other))).calibration);
  const adapted = { img_size: [640, 360], camera_matrix: cameraMatrix([500], [319.75, 179.75]) };
  const scaled = await found(json(200, { ...other, adapted }), { exact: true });
  assert.deepEqual([scaled.calibration.img_size, scaled.calibration.camera_matrix[0][0]], [[640, 360], 500]);
  const shown = (await found(json(200, { ...other, adapted }))).calibration;
  assert.deepEqual([shown.img_size, shown.exact_size], [[640, 360], true]);
  const reasonOf = async (known, maxError) => (await found(json(200, known), { maxError })).reason;
  assert.equal(await reasonOf(KNOWN, 0.25), "too_uncertain");
  assert.equal(await reasonOf(KNOWN, 1), null);
  assert.equal(await reasonOf({ ...KNOWN, spread: 2 }, 1), "too_uncertain");
});

test("a track says which camera it is", async () => {
  const track = camera({ width: 1280, height: 720 });
  const agent = "Mozilla/5.0 (Macintosh; Intel Mac OS X 10.15; rv:140.0) Gecko/20100101 Firefox/140.0";
  assert.deepEqual(cameraKey(track, agent), {
    camera: "FaceTime HD",
    platform: "Macintosh; Intel Mac OS X 10.15; rv:140.0",
    img_size: [1280, 720],
    zoom: 0,
  });
  assert.equal(platformOf("curl/8"), "curl/8");
  assert.throws(() => cameraKey(camera({}), agent), /no picture yet/);
  assert.throws(() => cameraKey({ ...track, readyState: "ended" }, agent), /has ended/);
  assert.throws(() => cameraKey({ ...track, kind: "audio" }, agent), /microphone/);
});

test("a device that its browser names is part of the platform", async () => {
  const userAgent = "Mozilla/5.0 (Linux; Android 10; K) AppleWebKit/537.36 Chrome/150.0.0.0 Mobile Safari/537.36";
  const here = (getHighEntropyValues) => platformHere({ userAgent, userAgentData: { getHighEntropyValues } });
  const telling = (model) => here(async () => ({ model, platformVersion: "14.0.0" }));
  assert.equal(await telling("Pixel 8"), "Linux; Android 14; Pixel 8");
  assert.equal(await telling(""), "Linux; Android 10; K");
  assert.equal(await platformHere({ userAgent }), "Linux; Android 10; K");
  const refused = new DOMException("no", "NotAllowedError");
  assert.equal(await here(() => Promise.reject(refused)), "Linux; Android 10; K");
});

const navigator = { userAgent: "Mozilla/5.0 (X11; Linux x86_64) Firefox/140.0" };
/** Lets what waits run until something holds. */
async function turn(holds = () => true) {
  do await new Promise(setImmediate);
  while (!holds());
}

test("a picture of another size is looked up again", async (t) => {
  setGlobals(t, { navigator });
  t.mock.timers.enable({ apis: ["setInterval"] });
  const track = camera({ width: 1280, height: 720, resizeMode: "none" });
  const { asked, options } = service(json(200, KNOWN));
  const answers = [];
  const signal = new AbortController();
  watch(track, { ...options, signal: signal.signal }, (answer) => answers.push(answer));
  await turn(() => answers.length === 1);
  t.mock.timers.tick(2000);
  await turn();
  assert.equal(asked[0].body.resize_mode, "none");
  track.settings = { width: 720, height: 1280 };
  track.dispatchEvent(new Event("configurationchange"));
  await turn(() => answers.length === 2);
  track.settings = { width: 640, height: 480 };
  t.mock.timers.tick(500);
  await turn(() => answers.length === 3);
  assert.deepEqual(asked.map(({ body }) => body.img_size).join(), "1280,720,720,1280,640,480");
  signal.abort();
  track.settings = { width: 320, height: 240 };
  t.mock.timers.tick(5000);
  track.dispatchEvent(new Event("configurationchange"));
  await turn();
  assert.equal(asked.length, 3);
});

test("a watched camera is looked up again after a failure that may pass", async (t) => {
  setGlobals(t, { navigator });
  const settle = async () => {
    for (let turns = 0; turns < 20; turns++) await turn();
  };
  for (const status of [503, 403]) {
    t.mock.timers.enable({ apis: ["setInterval", "setTimeout"] });
    const answers = [];
    let failing = true;
    const { options } = service(() => (failing ? json(status, {}) : json(200, KNOWN)));
    const stop = watch(camera({ width: 1280, height: 720 }), options, (answer) => answers.push(answer));
    await turn(() => answers.length === 1);
    assert.equal(answers[0].status, status);
    failing = false;
    t.mock.timers.tick(29_000);
    await settle();
    assert.equal(answers.length, 1);
    t.mock.timers.tick(2_000);
    // A lookup digests the camera's name in another thread: it takes an unknown number of turns.
    if (status === 503) await turn(() => answers[1]?.calibration);
    else await settle();
    assert.equal(answers.length, status === 503 ? 2 : 1);
    stop();
    t.mock.timers.reset();
  }
});

test("the way to the guidance page and back", async () => {
  const gone = [];
  const location = { href: "https://app.example/ar?x=1#menu=2", assign: (address) => gone.push(address) };
  const { asked, options } = service(json(200, { ...KNOWN, id: "ab/c", report: { verdict: {} } }));
  const leaving = calibrate({ ...options, source: KEY, location });
  assert.equal(await Promise.race([leaving, new Promise((done) => setTimeout(done, 10, "left"))]), "left");
  const there = new URL(gone[0]);
  assert.equal(there.searchParams.get("return_to"), location.href);
  assert.equal(there.searchParams.get("camera"), KEY.camera);

  const back = { ...location, href: `${location.href}&calibration=ab%2Fc` };
  const shown = [];
  const history = { state: 5, replaceState: (...what) => shown.push(what) };
  const calibration = await calibrate({ ...options, location: back, history });
  assert.equal(calibration.id, "ab/c");
  assert.ok(!("report" in calibration));
  assert.equal(asked[0].address, `${API}/calibrations/ab%2Fc`);
  assert.deepEqual(shown, [[5, "", location.href]]);
  assert.equal(await returned({ ...options, location, history }), null);

  for (const [status, cleaned] of [
    [404, 1],
    [410, 1],
    [403, 0],
  ]) {
    shown.length = 0;
    const refused = { ...service(json(status, { detail: "no" })).options, location: back, history };
    await assert.rejects(returned(refused), { name: "LookupError", status });
    assert.equal(shown.length, cleaned);
  }
});

test("the address of an answer is the digest that docs/api.md prints", async () => {
  const text = readFileSync(new URL("../../docs/api.md", import.meta.url), "utf8");
  const rows = [
    ...text.matchAll(/^\| `(.+?)` \| `(.+?)` \| (\d+)x(\d+) \| ([\d.]+) \| (\w+) \| `(\/known\/\S+)` \|$/gm),
  ];
  assert.ok(rows.length >= 3);
  for (const [, camera, platform, width, height, zoom, model, path] of rows) {
    const key = { camera, platform, img_size: [Number(width), Number(height)], zoom: Number(zoom) };
    const { href } = await edgeAddress(key, model, `${API}/`);
    assert.equal(href, `https://calibdb.example${path}`);
    const spelt = { ...key, camera: ` ${camera.normalize("NFD")}\t` };
    assert.equal((await edgeAddress(spelt, model, API)).href, href);
  }
  assert.equal(await edgeAddress({ ...KEY, resize_mode: "crop-and-scale" }, "rectilinear", API), null);
  assert.equal(await edgeAddress({ ...KEY, zoom: 0.0078125 }, "rectilinear", API), null);
});

test("a known camera is one GET without headers, and nothing else", async () => {
  const { all, options } = site(() => json(200, KNOWN), json(500, {}));
  const { calibration } = await lookup(KEY, options);
  assert.deepEqual(plain(calibration), KNOWN);
  const [{ path, request }, ...others] = all;
  assert.deepEqual([path, others], ["/known/v1/*/1280x720/0/rectilinear.json", []]);
  assert.deepEqual(
    [request.method, request.headers, request.credentials],
    [undefined, undefined, "omit"],
    "what a browser sends without asking first",
  );
});

test("the edge is asked once per hour and tab", async () => {
  const kept = new Map();
  const cache = storageOf(kept);
  const { all, options } = service(json(404, MISS));
  const paths = () => all.map(({ path: each }) => each);
  const path = "/known/v1/*/1280x720/0/rectilinear.json";
  for (let n = 0; n < 3; n++) assert.equal((await lookup(KEY, { ...options, cache })).reason, "too_few");
  assert.deepEqual(paths(), [path, "/v1/lookup", "/v1/lookup", "/v1/lookup"]);
  const [name] = [...kept].find(([, value]) => Math.abs(Number(value) - Date.now()) < 60_000);
  kept.set(name, String(Date.now() - 3_600_001));
  await lookup(KEY, { ...options, cache });
  await lookup({ ...KEY, zoom: 2 }, { ...options, cache });
  assert.deepEqual(paths().slice(4), [path, "/v1/lookup", "/known/v1/*/1280x720/2/rectilinear.json", "/v1/lookup"]);
  assert.equal((await lookup(KEY, { ...options, cache: FULL })).reason, "too_few");
});

test("during an outage known cameras are still found", async () => {
  for (const failing of [json(503, { detail: "Service Unavailable" }), unreachable]) {
    const known = site(() => json(200, KNOWN), failing);
    assert.ok((await lookup(KEY, known.options)).calibration);
    await assert.rejects(
      found(failing),
      (error) =>
        error instanceof LookupError && /cannot be asked now/.test(error.message) && error.cause instanceof LookupError,
    );
  }
});

test("a failing edge does not block a lookup", async () => {
  for (const edge of [unreachable, () => json(500, {}), () => json(200, {})]) {
    const { options } = site(edge, json(200, KNOWN));
    assert.ok((await lookup(KEY, options)).calibration.camera_matrix);
  }
});

test("the faster of edge and service answers", async () => {
  const stuck = site(never, json(200, KNOWN));
  assert.ok((await lookup(KEY, stuck.options)).calibration);
  let asked = () => {};
  const inService = new Promise((resolve) => {
    asked = resolve;
  });
  const late = site(
    async () => {
      await inService;
      return json(200, KNOWN);
    },
    (request) => {
      asked();
      return never(request);
    },
  );
  assert.ok((await lookup(KEY, late.options)).calibration);
  const given = new AbortController();
  const up = site((request) => {
    given.abort(new Error("enough"));
    return never(request);
  });
  await assert.rejects(lookup(KEY, { ...up.options, signal: given.signal }), /enough/);
});

// What a bundle answers is compared with the service's answers in tests/service/test_bundle.py.
const bundle = { find: ({ camera }) => (camera === KEY.camera ? KNOWN : null) };

test("a bundled camera needs no token and no network", async () => {
  const { calibration, guidanceUrl } = await lookup(KEY, { bundle, cache: null });
  assert.ok(calibration instanceof Calibration);
  assert.equal(guidanceUrl, null);
});

test("other cameras are looked up online or lead to guidance", async () => {
  const stranger = { ...KEY, camera: "Another" };
  const { asked, options } = service(json(403, { detail: "no" }));
  const { calibration, guidanceUrl, reason } = await lookup(stranger, { ...options, bundle, token: undefined });
  assert.deepEqual([calibration, reason, new URL(guidanceUrl).pathname], [null, "unknown_camera", "/calibrate/"]);
  assert.equal(asked.length, 0, "without a token there is no request");
  await assert.rejects(lookup(stranger, { ...options, bundle }), { status: 403 });
  assert.ok((await lookup(KEY, { ...options, bundle })).calibration);
  assert.equal(asked.length, 1);
});

test("another file is refused in words", () => {
  for (const data of [null, { format: "calibdb-bundle", version: 2 }, { format: "cameras", version: 1 }])
    assert.throws(() => new Bundle(data), /no bundle/);
});
