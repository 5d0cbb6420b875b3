import assert from "node:assert/strict";
import { test } from "node:test";
import { Detector } from "../../web/lib/detector.js";
import { setGlobals } from "./globals.mjs";

/** @type {{id: number}[]} what the worker was asked, in order */
let asked = [];
/** @type {(answer: {data: object}) => void} */
let answer;

class SilentWorker {
  constructor() {
    answer = (event) => this.onmessage(event);
  }

  postMessage(message) {
    asked.push(message);
  }
}

/** A clock for the detector that each test opens, and its worker. */
function standStill(t) {
  asked = [];
  setGlobals(t, { Worker: SilentWorker });
  t.mock.timers.enable({ apis: ["setTimeout"] });
  return t.mock.timers;
}

const frame = () => ({ close() {} });

test("a frame that waits for a slow look at every kind of board is not given up", async (t) => {
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
