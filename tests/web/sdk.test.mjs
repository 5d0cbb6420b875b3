import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { gzipSync } from "node:zlib";
import { LookupError, cameraKey, lookup, platformHere, platformOf } from "../../web/sdk/calibdb.js";

const KEY = { camera: "C920 (046d:082d)", platform: "X11; Linux x86_64", img_size: [1280, 720], zoom: 0 };
const answer = (status, body) => async (address, request) => {
  answer.asked = { address: String(address), ...request, body: JSON.parse(request.body) };
  return new Response(JSON.stringify(body), { status, headers: { "content-type": "application/json" } });
};

test("a known camera is answered with its calibration", async () => {
  const calibration = { camera_matrix: [[1000, 0, 640], [0, 1000, 360], [0, 0, 1]], reliable: true };
  const result = await lookup(KEY, { token: "cdb_a_b", model: "fisheye", api: "https://calibdb.example/v1", fetch: answer(200, calibration) });
  assert.deepEqual(result, { calibration, guidanceUrl: null, reason: null });
  const { address, method, headers, body } = answer.asked;
  assert.deepEqual([address, method, headers.authorization], ["https://calibdb.example/v1/lookup", "POST", "Bearer cdb_a_b"]);
  assert.deepEqual(body, { ...KEY, distortion_model: "fisheye", redirect: false });
});

test("an unknown camera is answered with where to calibrate it", async () => {
  const body = { status: 404, guidance_url: "https://calibdb.example/calibrate/?camera=x", reason: "too_few" };
  const result = await lookup(KEY, { token: "t", api: "https://calibdb.example/v1/", fetch: answer(404, body) });
  assert.deepEqual(result, { calibration: null, guidanceUrl: body.guidance_url, reason: "too_few" });
  assert.equal(answer.asked.address, "https://calibdb.example/v1/lookup");
});

test("anything else is an error with its status and the service's words", async () => {
  const promise = lookup(KEY, { token: "t", api: "https://c.example/v1", fetch: answer(403, { detail: "The API token is not valid." }) });
  await assert.rejects(promise, (error) => error instanceof LookupError && error.status === 403 && /token/.test(error.message));
  const proxy = async () => new Response("<h1>Bad gateway</h1>", { status: 502 });
  await assert.rejects(lookup(KEY, { token: "t", api: "https://c.example/v1", fetch: proxy }), { status: 502 });
});

test("a track says which camera it is", () => {
  const track = { label: "FaceTime HD", getSettings: () => ({ width: 1280, height: 720 }) };
  const agent = "Mozilla/5.0 (Macintosh; Intel Mac OS X 10.15; rv:140.0) Gecko/20100101 Firefox/140.0";
  assert.deepEqual(cameraKey(track, agent), {
    camera: "FaceTime HD", platform: "Macintosh; Intel Mac OS X 10.15; rv:140.0", img_size: [1280, 720], zoom: 0,
  });
  assert.equal(platformOf("curl/8"), "curl/8");
  assert.throws(() => cameraKey({ label: "x", getSettings: () => ({}) }, agent), TypeError);
});

test("a device that its browser names is part of the platform", async () => {
  const userAgent = "Mozilla/5.0 (Linux; Android 10; K) AppleWebKit/537.36 Chrome/150.0.0.0 Mobile Safari/537.36";
  const telling = (hints) => ({ userAgent, userAgentData: { getHighEntropyValues: async () => hints } });
  assert.equal(await platformHere(telling({ model: "Pixel 8", platformVersion: "14.0.0" })), "Linux; Android 14; Pixel 8");
  assert.equal(await platformHere(telling({ model: "", platformVersion: "14.0.0" })), "Linux; Android 10; K");
  assert.equal(await platformHere({ userAgent }), "Linux; Android 10; K");
  const refusing = { userAgent, userAgentData: { getHighEntropyValues: () => Promise.reject(new DOMException("no", "NotAllowedError")) } };
  assert.equal(await platformHere(refusing), "Linux; Android 10; K");
});

test("it is below 8 KB compressed and imports nothing", () => {
  const source = readFileSync(new URL("../../web/sdk/calibdb.js", import.meta.url));
  assert.ok(gzipSync(source).length < 8192);
  assert.doesNotMatch(source.toString(), /^import /m);
});
