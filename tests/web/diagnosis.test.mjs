import assert from "node:assert/strict";
import { test } from "node:test";
import { DEFAULT_BOARD } from "../../web/lib/board.js";
import { arrows } from "../../web/calibrate/overlay-layer.js";
import { HEALTHY, diagnose } from "../../web/lib/capture/sight.js";
import { blackSquares } from "../../web/lib/capture/marks.js";
import { exposure, sharpness, frameMetrics, moire } from "../../web/lib/frame-metrics.js";
import { Painter } from "../../web/lib/virtual/painter.js";
import { METRICS, PINHOLE, cornersSeen, rectangle, see } from "./scenes.mjs";
import { degrade, smear } from "../../web/lib/virtual/degrade.js";

const SIZE = [1280, 720];
const LENS = { ...PINHOLE, cx: 664.5, cy: 359.5, k1: -0.25 };
const POSES = [
  { rvec: [0.35, -0.45, 0.1], tvec: [-4, -3, 9] },
  { rvec: [0, 0, 0], tvec: [-4, -3, 7] },
  { rvec: [0.7, -0.45, 0.1], tvec: [-4, -3, 14] },
];
const painter = new Painter(DEFAULT_BOARD, LENS, SIZE);
const foundAt = (pose) => cornersSeen(DEFAULT_BOARD, LENS, pose);
const painted = new Map();
function seen(pose, spoilt = () => {}) {
  if (!painted.has(pose)) {
    painted.set(pose, new Uint8ClampedArray(4 * SIZE[0] * SIZE[1]));
    painter.paint(pose, painted.get(pose));
  }
  const picture = { width: SIZE[0], height: SIZE[1], data: painted.get(pose).slice() };
  spoilt(picture);
  const data = new Uint8Array(SIZE[0] * SIZE[1]);
  for (let at = 0; at < data.length; at++) data[at] = picture.data[4 * at];
  return { width: SIZE[0], height: SIZE[1], data };
}

/** The same picture with other values: by value and column. */
const changed = (image, change) => ({ ...image, data: image.data.map((value, at) => change(value, at % SIZE[0])) });

test("edges in focus are sharp, smeared ones are not, in either direction", () => {
  for (const pose of POSES) {
    const { points } = foundAt(pose);
    const sharp = sharpness(seen(pose), points);
    assert.ok(sharp > 0.1, `in focus ${sharp}`);
    for (const along of [1, SIZE[0]]) {
      const blurred = sharpness(
        seen(pose, (picture) => smear(picture, 9, along)),
        points,
      );
      assert.ok(blurred < 0.072, `smeared ${blurred}`);
    }
  }
  assert.equal(sharpness(seen(null), []), null);
});

test("moiré shows in the white of the board, and sensor noise does not", () => {
  let seed = 1;
  const random = () => (seed = (seed * 16807) % 2147483647) / 2147483647;
  for (const pose of POSES) {
    const found = foundAt(pose);
    assert.ok(moire(seen(pose), DEFAULT_BOARD, found) < 0.01);
    assert.ok(
      moire(
        seen(pose, (picture) => degrade(picture, "moire")),
        DEFAULT_BOARD,
        found,
      ) > 0.1,
    );
    const noise = () => 20 * (random() + random() + random() - 1.5);
    const noisy = changed(seen(pose), (value) => Math.max(0, Math.min(255, value + noise())));
    assert.ok(moire(noisy, DEFAULT_BOARD, found) < 0.05);
  }
});

test("moiré is looked for in bright parts of the board", () => {
  const inverted = { ...DEFAULT_BOARD, inverted: true };
  for (const pose of POSES) {
    const found = foundAt(pose);
    const print = seen(pose);
    const negative = changed(print, (value) => 255 - value);
    assert.ok(moire(negative, inverted, found) < 0.01);
    // The squares that are dark on an inverted board are those with the markers.
    const glossy = changed(print, (value, x) => (value >= 128 ? 30 + (x % 40 < 20 ? 60 : 0) : 255 - value));
    assert.ok(moire(glossy, inverted, found) < 0.1);
    const shaded = changed(print, (value, x) => value * (0.4 + (0.6 * x) / SIZE[0]));
    assert.ok(moire(shaded, DEFAULT_BOARD, found) < 0.02);
    const striped = changed(print, (value, x) => (value < 128 ? 255 - (x % 16 < 8 ? 70 : 0) : 255 - value));
    assert.ok(moire(striped, inverted, found) > 0.1);
  }
});

test("three corners of one square suffice", () => {
  const { ids, points } = foundAt(POSES[1]);
  const few = [1, 2, 9].map((id) => ids.indexOf(id));
  const found = { ids: few.map((n) => ids[n]), points: few.map((n) => points[n]) };
  const striped = seen(POSES[1], (picture) => degrade(picture, "moire"));
  assert.ok((moire(striped, DEFAULT_BOARD, found) ?? 0) > 0.1);
  assert.equal(moire(striped, DEFAULT_BOARD, { ids: found.ids.slice(1), points: found.points.slice(1) }), null);
});

test("exposure is what the picture's histogram says", () => {
  const flat = (value) => exposure({ width: 64, height: 64, data: new Uint8Array(4096).fill(value) });
  assert.deepEqual(flat(20), { median: 20, high: 20, overexposed: 0 });
  assert.equal(flat(255).overexposed, 1);
});

/** Diagnosis after two seconds of such frames at 20 a second. */
function said(detection, { motion = 0, every = 33, from = HEALTHY } = {}) {
  let state = from;
  for (let time = 1000; time <= 3400; time += every) {
    state = diagnose(state, { size: SIZE, markers: 0, ids: [], points: [], ...detection }, motion, time);
    if (time === 1000) assert.equal(state.trouble, null);
  }
  return state.trouble;
}
/** The same of frames whose metrics differ so from good ones. */
const saidOf = (metrics, detection = {}) => said({ ...detection, metrics: { ...METRICS, ...metrics } });
test("each trouble is named once it lasts", () => {
  const found = foundAt(POSES[0]);
  const good = { ...METRICS, share: 1, square: 60, moire: 0.01 };
  const board = { ...found, metrics: good };
  assert.equal(said(board), null);
  assert.equal(saidOf({}), null);
  assert.equal(saidOf({ median: 12, high: 30 }), "dark");
  assert.equal(saidOf({ overexposed: 0.4 }), "bright");
  assert.equal(saidOf({ sharpness: 0.06 }), "blurred");
  assert.equal(saidOf({ square: 12 }, { markers: 9 }), "far");
  assert.equal(saidOf({ ...good, square: 12 }, found), "far");
  assert.equal(saidOf({ ...good, moire: 0.12 }, found), "moire");
  assert.equal(saidOf({ ...good, moire: 0.08 }, found), null);
  assert.equal(saidOf({ ...good, sharpness: 0.06 }, found), null, "blur that hides no corner does no harm");
  assert.equal(saidOf({ ...good, sharpness: 0.06, share: 0.4 }, found), "blurred");
  assert.equal(said(board, { motion: 20 }), "moving");
  assert.equal(said(board, { motion: 5 }), null);
  assert.equal(said(board, { motion: 20, every: 170 }), null, "slow, in a camera of few frames");
  for (const other of ["mirrored", "legacy", "wrong_board"])
    assert.equal(said({ metrics: METRICS }, { from: { ...HEALTHY, other } }), other);
  assert.equal(said(board, { from: { ...HEALTHY, other: "legacy" } }), null, "the board itself is seen");
});

test("trouble is forgotten when the board is seen well", () => {
  const board = { ...foundAt(POSES[0]), markers: 27, size: SIZE, metrics: { ...METRICS, square: 60, moire: 0 } };
  assert.equal(diagnose({ ...HEALTHY, trouble: "dark" }, board, 0, 5000).trouble, null);
});

test("the metrics of a frame are read from it", () => {
  const { square, moire: unevenness } = frameMetrics(seen(POSES[0]), DEFAULT_BOARD, foundAt(POSES[0]), 0);
  assert.ok(square > 60 && square < 90);
  assert.equal(unevenness, 0);
  assert.equal(frameMetrics(seen(null), DEFAULT_BOARD, { ids: [], points: [] }, 13).square, 20);
});

test("arrows go from the board as seen to the target, about what is said", () => {
  const aim = rectangle(100, 100, 200, 100);
  const moved = aim.map(([x, y]) => [x + 200, y]);
  assert.deepEqual(arrows("left", moved, aim, 1280), [[400, 150, 200, 150]]);
  const small = rectangle(150, 125, 100, 50);
  assert.deepEqual(
    arrows("closer", small, aim, 1280).map(([, , x, y]) => [x, y]),
    aim,
  );
  assert.deepEqual(
    arrows("tilt_right", small, aim, 1280).map(([, , x]) => x),
    [300, 300],
  );
  assert.deepEqual(
    arrows("tilt_top", small, aim, 1280).map(([, , , y]) => y),
    [100, 100],
  );
  assert.deepEqual(arrows("hold", small, aim, 1280), []);
  assert.deepEqual(arrows("left", null, aim, 1280), []);
});

test("the ghost is the board, its rim included", () => {
  const flat = { ...LENS, k1: 0 };
  const pose = { rvec: [0, 0, 0], tvec: [-4.5, -3, 12] };
  const { ids, points } = cornersSeen(DEFAULT_BOARD, flat, pose);
  const squares = blackSquares(DEFAULT_BOARD, { ids, corners: points });
  assert.equal(squares.length, 27);
  const [[x, y]] = see(flat, pose, [[0, 0]]);
  assert.ok(squares.flat().some(([u, v]) => Math.hypot(u - x, v - y) < 1e-6));
  assert.equal(blackSquares(DEFAULT_BOARD, { ids: [], corners: [] }).length, 0);
});
