import assert from "node:assert/strict";
import { test } from "node:test";
import { spreadOf } from "../../web/cameras/agreement.js";
import { splitLabel, systemName } from "../../web/lib/camera-name.js";
import { valueText } from "../../web/lib/result/values.js";
import { lensDifference } from "../../web/lib/lens-difference.js";
import { widthOf } from "../../web/cameras/list.js";
import { forgetOwn, keepOwn, ownCalibrations } from "../../web/lib/own-calibrations.js";
import { agreementOf, followAgreement } from "../../web/lib/result/agreement.js";
import { askPhoneModel, modelsOf, phoneModel } from "../../web/lib/phone-model.js";
import { countsOf } from "../../web/landing/counts.js";
import { BITS } from "../../web/landing/capture-loop.js";
import { DEFAULT_BOARD, markers } from "../../web/lib/board.js";
import { markerBits } from "../../web/lib/board-drawing.js";
import { keepHere } from "./globals.mjs";
import { calibrationOf } from "./scenes.mjs";

const lens = (f, cx) => calibrationOf([f], [cx, 360], { distortion_coefficients: [-0.1, 0.02, 0, 0, 0] });

test("systems have the names that people use", () => {
  const named = {
    "X11; Linux x86_64": "Linux",
    "Macintosh; Intel Mac OS X 10_15_7": "macOS",
    "Windows NT 10.0; Win64; x64": "Windows",
    "Linux; Android 14; Pixel 7": "Android · Pixel 7",
    "Linux; Android 10; K": "Android",
    "X11; CrOS x86_64 14541.0.0": "ChromeOS",
    "iPhone; CPU iPhone OS 17_0 like Mac OS X": "iOS",
    photographs: "photographs",
  };
  for (const [platform, name] of Object.entries(named)) assert.equal(systemName(platform), name);
  assert.deepEqual(splitLabel("HD Pro Webcam C920 (046d:082D)"), { name: "HD Pro Webcam C920", usb: "046d:082d" });
  assert.deepEqual(splitLabel("Camera (front)"), { name: "Camera (front)", usb: null });
});

test("small numbers have a power of ten, and their error the same one", () => {
  assert.deepEqual(valueText(0.000011, 0.000027, 6, ""), {
    value: "1.1\u00a0×\u00a010⁻⁵",
    std: "±\u00a02.7\u00a0×\u00a010⁻⁵",
  });
  assert.deepEqual(valueText(-0.28223, 0.0014, 4, ""), { value: "−0.2822", std: "±\u00a00.0014" });
  assert.deepEqual(valueText(977.734, 0.56, 2, "px"), { value: "977.73\u00a0px", std: "±\u00a00.56\u00a0px" });
  assert.equal(valueText(0, null, 5, "").value, "0.00000");
});

test("the difference of two lenses leaves out how the camera was turned", () => {
  const one = lens(900, 640);
  assert.ok(lensDifference(one, one).max < 1e-6);
  // A principal point that moved by 5 px is nearly a turn by 5/900; what is left is distortion that moved with it.
  const moved = lensDifference(one, lens(900, 645));
  assert.ok(moved.rms < 1.5 && moved.max < 5, `${moved.rms} ${moved.max}`);
  const longer = lensDifference(one, lens(909, 640));
  // One per cent of the focal length is one per cent of the distance to the centre, 0 to 7 px.
  assert.ok(Math.abs(longer.rms - 4.1) < 0.5 && longer.max > 6 && longer.max < 7.3, `${longer.rms} ${longer.max}`);
});

test("the error of a consensus is the spread of its model", () => {
  const member = (fx, model = "rectilinear", in_group = true) => ({
    fx,
    fy: fx,
    cx: 640,
    cy: 360,
    model,
    in_group,
  });
  const spread = spreadOf(
    [member(970), member(980), member(990), member(2000, "fisheye"), member(1200, "rectilinear", false)],
    "rectilinear",
  );
  assert.equal(spread.count, 3);
  assert.ok(Math.abs(spread.fx - 10) < 1e-9 && spread.cx === 0);
  assert.equal(spreadOf([member(970)], "rectilinear"), null);
});

const { signal } = new AbortController();
const mode = {
  img_size: [1280, 720],
  zoom: 0,
  agreeing: 2,
  required: 5,
  reason: "too_few",
  groups: [["a", "b"]],
  members: [{ id: "a" }, { id: "b" }, { id: "c" }],
};

test("a calibration agrees once the consensus counts it", () => {
  const at = (id) => agreementOf("key", { modes: [mode] }, { id, img_size: [1280, 720], zoom: 0 });
  assert.deepEqual(at("a"), { key: "key", agreeing: 2, required: 5, reliable: false, settled: true });
  assert.equal(at("c").settled, false);
  assert.equal(agreementOf("key", { modes: [] }, { id: "a", img_size: [1280, 720], zoom: 0 }).agreeing, 1);
});

test("the agreement is polled until the calibration counts", async (t) => {
  const asked = [];
  t.mock.method(globalThis, "fetch", async (url) => {
    const { pathname } = new URL(String(url), "http://page.example/");
    if (pathname.endsWith("config.json")) return Response.json({ api: "/v1", token: "t" });
    asked.push(pathname);
    return Response.json({ modes: [asked.length < 3 ? mode : { ...mode, agreeing: 3, groups: [["a", "b", "c"]] }] });
  });
  keepHere(t);
  const agreements = [];
  const follow = async (id) => {
    agreements.length = 0;
    const tell = (agreement) => agreements.push(agreement.agreeing);
    await followAgreement("key", { id, img_size: [1280, 720], zoom: 0 }, signal, tell, async () => {});
  };
  await follow("c");
  assert.deepEqual(agreements, [2, 2, 3]);
  await follow("d");
  assert.equal(agreements.length, 1);
});

test("own calibrations are kept once, the newest first", (t) => {
  const kept = keepHere(t);
  const own = (id) => ({ id, camera: "C920", img_size: [1280, 720], time: 1, level: "good", rms: 0.1 });
  for (const id of ["a", "b", "a"]) keepOwn(own(id));
  assert.deepEqual(
    ownCalibrations().map(({ id }) => id),
    ["a", "b"],
  );
  for (let index = 0; index < 120; index++) keepOwn(own(`n${index}`));
  assert.equal(ownCalibrations().length, 100);
  forgetOwn("n119");
  assert.equal(ownCalibrations()[0].id, "n118");
  forgetOwn();
  assert.equal(kept.size, 0);
  kept.set("calibdb.own", "{broken");
  assert.deepEqual(ownCalibrations(), []);
});

test("the width of view follows from the focal length and the model", () => {
  const at = (fx, model) => widthOf({ fx, img_size: [1000, 500], models: [model] });
  assert.ok(Math.abs(at(500, "rectilinear") - 90) < 1e-9);
  assert.ok(Math.abs(at(1000 / Math.PI, "fisheye") - 180) < 1e-9);
  assert.deepEqual([at(null, "rectilinear"), at(700, "omnidirectional")], [null, null]);
});

const SAFARI = "Mozilla/5.0 (iPhone; CPU iPhone OS 17_5 like Mac OS X) AppleWebKit/605.1.15";
const MAC = "Mozilla/5.0 (Macintosh; Intel Mac OS X 10_15_7) AppleWebKit/605.1.15";
const air = { width: 420, height: 912, ratio: 3 };

test("the screen leaves few models, upright or turned", () => {
  const upright = modelsOf({ width: 390, height: 844, ratio: 3 });
  assert.deepEqual(upright, modelsOf({ width: 844, height: 390, ratio: 3 }));
  assert.ok(upright.some(([, id]) => id === "iPhone14,5"));
  assert.ok(upright.length <= 6);
  assert.deepEqual(modelsOf({ width: 391, height: 844, ratio: 3 }), []);
});

test("identifiers are Apple's, and none stands for two models", () => {
  const ids = [];
  for (let width = 320; width < 500; width++)
    for (let height = 500; height < 1000; height++)
      for (const ratio of [2, 3]) ids.push(...modelsOf({ width, height, ratio }).map(([, id]) => id));
  assert.equal(new Set(ids).size, ids.length);
  for (const id of ids) assert.match(id, /^iPhone[0-9]{1,2},[0-9]$/);
  assert.ok(ids.length > 35);
});

test("only ambiguous iPhones are asked about", async (t) => {
  const kept = keepHere(t);
  const ask = (userAgent, screen) => askPhoneModel(signal, { userAgent, screen });
  assert.equal(await ask(MAC, air), "");
  assert.equal(await ask(SAFARI, { width: 1, height: 2, ratio: 3 }), "");
  assert.equal(kept.size, 0);
  assert.equal(await ask(SAFARI, air), "iPhone18,4");
  assert.equal(phoneModel(), "iPhone18,4");
  kept.set("calibdb.phone-model", "-");
  assert.equal(await ask(SAFARI, air), "", "who does not know is not asked again");
});

test("cameras and those ready at any size are counted", () => {
  const size = (reliable, calibrations) => ({ reliable, calibrations });
  const cameras = [
    { sizes: [size(true, 6), size(false, 2)] },
    { sizes: [size(false, 1)] },
    { sizes: [size(true, 5), size(true, 7)] },
  ];
  assert.deepEqual(countsOf(cameras, false), { cameras: 3, ready: 2, calibrations: 21, more: false });
  assert.deepEqual(countsOf([], false), { cameras: 0, ready: 0, calibrations: 0, more: false });
});

test("the board of the loop has the markers of the default board", () => {
  const bits = markers(DEFAULT_BOARD).map(({ id }) =>
    markerBits(DEFAULT_BOARD.dictionary, id)
      .flat()
      .reduce((all, bit) => 2 * all + Number(bit), 0)
      .toString(16)
      .padStart(4, "0"),
  );
  assert.equal(BITS, bits.join(""));
});
