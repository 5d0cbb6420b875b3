import assert from "node:assert/strict";
import { test } from "node:test";
import { Detector } from "../../web/lib/detector.js";
import { setGlobals } from "./globals.mjs";
import { Feedback } from "../../web/lib/capture/feedback.js";
import { colour } from "../../web/calibrate/tint.js";
import { latest } from "../../web/lib/latest.js";
import { Sharpest } from "../../web/lib/rank.js";

/** @type {{id: number}[]} what the worker was asked, in order */
let asked = [];
let answer;

class SilentWorker {
  constructor() {
    answer = (event) => this.onmessage(event);
  }

  postMessage(message) {
    asked.push(message);
  }
}

function standStill(t) {
  asked = [];
  setGlobals(t, { Worker: SilentWorker });
  t.mock.timers.enable({ apis: ["setTimeout"] });
  return t.mock.timers;
}

const frame = () => ({ close() {} });

test("a frame may wait for a slow look at all boards", async (t) => {
  const timers = standStill(t);
  const detector = new Detector();
  const sighting = detector.sight(frame());
  const detection = detector.detect(frame());
  timers.tick(20_000);
  answer({ data: { id: asked[0].id, result: "seen" } });
  answer({ data: { id: asked[1].id, result: "found" } });
  assert.deepEqual(await Promise.all([sighting, detection]), ["seen", "found"]);
});

test("a worker that answers no frame is reported after four seconds", async (t) => {
  const timers = standStill(t);
  const detection = new Detector().detect(frame());
  timers.tick(3_999);
  const outcome = assert.rejects(detection, /does not answer/);
  timers.tick(2);
  await outcome;
});

test("a worker that never opens is reported after twenty seconds", async (t) => {
  const timers = standStill(t);
  t.mock.method(globalThis, "fetch", async () => Response.json({ bytes: 1 }));
  const outcome = assert.rejects(Detector.open({}), /does not answer/);
  while (asked.length === 0) await new Promise(setImmediate);
  timers.tick(20_001);
  await outcome;
});

test("the loudspeaker rests between signs", (t) => {
  const tones = [];
  const states = [];
  const part = () => ({ gain: { setValueAtTime() {}, exponentialRampToValueAtTime() {} }, connect: (next) => next });
  const AudioContext = class {
    currentTime = 0;
    destination = {};
    resume() {
      states.push("running");
    }
    suspend() {
      states.push("suspended");
    }
    createGain() {
      return part();
    }
    createOscillator() {
      const tone = { frequency: {}, start() {}, stop() {}, ...part() };
      tones.push(tone);
      return tone;
    }
  };
  const navigator = { userActivation: { hasBeenActive: true } };
  setGlobals(t, { AudioContext, navigator, localStorage: { getItem: () => null } });
  const feedback = new Feedback();
  feedback.give("taken");
  assert.deepEqual([tones.length, states], [2, ["running"]]);
  tones[0].onended();
  assert.deepEqual(states, ["running"]);
  tones[1].onended();
  assert.deepEqual(states, ["running", "suspended"]);
  feedback.give("hold");
  tones[2].onended();
  assert.deepEqual(states, ["running", "suspended", "running", "suspended"]);
});

test("green and magenta become the target's colours", () => {
  const data = new Uint8ClampedArray([0, 255, 0, 255, 255, 0, 255, 255, 0, 0, 0, 255]);
  colour(data);
  assert.deepEqual([...data], [255, 176, 0, 255, 184, 153, 102, 255, 0, 0, 0, 255]);
});

test("a stale run's error is dropped, the latest one's is not", async () => {
  const run = latest(async (signal, wait) => {
    await wait;
    signal.throwIfAborted();
    throw new RangeError("failed");
  });
  const [stale, current] = [run(Promise.resolve()), run(Promise.resolve())];
  assert.equal(await stale, undefined);
  await assert.rejects(current, RangeError);
});

test("a cancelled run is stale too", async () => {
  const run = latest(async () => "late");
  const cancelled = run();
  run.cancel();
  assert.equal(await cancelled, undefined);
  assert.equal(await run(), "late");
});

const at = (x, sharpness, count = 12) => ({
  ids: Array.from({ length: count }, (_, id) => id),
  points: Array.from({ length: count }, (_, id) => [x + 20 * (id % 4), 100 + 20 * Math.floor(id / 4)]),
  outline: null,
  sharpness,
});

test("of each place the sharpest frame is kept, and few corners are none", () => {
  const frames = new Sharpest();
  for (const frame of [at(100, 0.1), at(110, 0.2), at(120, 0.15), at(600, 0.1), at(900, 0.3, 5)])
    frames.add(frame, 1280);
  const starts = frames
    .best(12, [1280, 720])
    .map(({ points }) => points[0][0])
    .sort((a, b) => a - b);
  assert.deepEqual(starts, [110, 600]);
  assert.equal(frames.best(1, [1280, 720]).length, 1);
});
