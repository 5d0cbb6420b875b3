import assert from "node:assert/strict";
import { test } from "node:test";
import { Bundle } from "../../web/sdk/bundle.js";
import { lookup } from "../../web/sdk/calibdb.js";

// What a file holds is compared with the service's answers in tests/service/test_bundle.py.
const COLUMNS = [
  "img_size",
  "zoom",
  "distortion_model",
  "intrinsics",
  "distortion_coefficients",
  "uncertainty",
  "spread",
  "relation",
  "at",
];
const row = (size, f, at = {}, model = "rectilinear") => [
  size,
  0,
  model,
  [f, f, 640, 360],
  [-0.1, 0, 0, 0, 0],
  [0.2, 0.5],
  0.3,
  null,
  at,
];
const DATA = {
  format: "calibdb-bundle",
  version: 1,
  columns: COLUMNS,
  cameras: [
    {
      camera: "C920 (046d:082d)",
      platform: "X11; Linux x86_64",
      rows: [row([1280, 720], 1000, { "960x540": ["scale", 750, 750, 480, 270] }), row([640, 480], 600)],
    },
    { camera: "camera 0, facing back", platform: "Linux; Android 14; Pixel 8", rows: [row([1920, 1080], 1500)] },
  ],
  labels: { "C920 (046d:082d)": 0, C920: 0 },
  places: { "android; pixel 8": { "camera 0, facing back": 1 } },
};
const KEY = { camera: "C920", platform: "Windows NT 10.0; Win64; x64; rv:140.0", img_size: [1280, 720], zoom: 0 };
const bundle = new Bundle(DATA);

test("a camera that came with the application needs no token and no network", async () => {
  const { calibration, guidanceUrl } = await lookup(KEY, { bundle, cache: null });
  assert.deepEqual([calibration.camera_matrix[0], calibration.exact_size, guidanceUrl], [[1000, 0, 640], true, null]);
  assert.deepEqual(calibration.project([0, 0, 1]), [640, 360]);
  const pixel = {
    camera: "camera 0, facing back",
    platform: "Linux; Android 15; Pixel 8",
    img_size: [1920, 1080],
    zoom: 0,
  };
  assert.equal((await lookup(pixel, { bundle, cache: null })).calibration.camera_matrix[0][0], 1500);
});

test("what it does not know is asked of the service, or leads to the guidance page where nobody is asked", async () => {
  const stranger = { ...KEY, camera: "toString" };
  const { calibration, guidanceUrl, reason } = await lookup(stranger, {
    bundle,
    cache: null,
    api: "https://calibdb.example/v1",
  });
  assert.deepEqual([calibration, reason, new URL(guidanceUrl).pathname], [null, "unknown_camera", "/calibrate/"]);
  const asked = [];
  const fetch = async (address) => (
    asked.push(String(address)),
    new Response(JSON.stringify({ detail: "no" }), { status: 403, headers: { "content-type": "application/json" } })
  );
  const online = { bundle, fetch, cache: null, token: "cdb_a_b", api: "https://calibdb.example/v1" };
  for (const key of [
    stranger,
    { ...KEY, zoom: 2 },
    { ...KEY, resize_mode: "crop-and-scale" },
    { ...KEY, platform: "Linux; Android 10; K" },
  ]) {
    await assert.rejects(lookup(key, online), { status: 403 });
  }
  await assert.rejects(lookup(KEY, { ...online, model: "fisheye" }), { status: 403 });
  const posts = () => asked.filter((address) => address.endsWith("/v1/lookup")).length;
  assert.equal(posts(), 5);
  const before = asked.length;
  assert.ok((await lookup(KEY, online)).calibration);
  assert.equal(asked.length, before);
  await assert.rejects(lookup(KEY, { cache: null }), /API token/);
});

test("another size is answered by the closest, marked, or by what was verified for it", async () => {
  const at = async (img_size, wish = {}) => lookup({ ...KEY, img_size }, { bundle, cache: null, ...wish });
  const closest = await at([800, 600]);
  assert.deepEqual([closest.calibration.img_size, closest.calibration.exact_size], [[640, 480], false]);
  assert.equal((await at([800, 600], { exact: true })).reason, "other_size");
  const verified = (await at([960, 540], { exact: true })).calibration;
  assert.deepEqual(
    [verified.img_size, verified.camera_matrix[0], verified.relation],
    [[960, 540], [750, 0, 480], "scale"],
  );
  assert.equal((await at([1280, 720], { maxError: 0.1 })).reason, "too_uncertain");
});

test("another file is refused in words", () => {
  for (const data of [null, {}, { ...DATA, version: 2 }, { ...DATA, format: "cameras" }])
    assert.throws(() => new Bundle(data), /no bundle/);
});
