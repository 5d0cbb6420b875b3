import assert from "node:assert/strict";
import { afterEach, beforeEach, mock, test } from "node:test";
import { Detector } from "../../web/lib/detector.js";

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

beforeEach(() => {
  asked = [];
  globalThis.Worker = SilentWorker;
  mock.timers.enable({ apis: ["setTimeout"] });
});
afterEach(() => {
  mock.timers.reset();
  delete globalThis.Worker;
});

const frame = () => ({ close() {} });

test("a frame that waits for a slow look at every kind of board is not given up", async () => {
  const detector = new Detector();
  const sighting = detector.sight(frame());
  const detection = detector.detect(frame());
  mock.timers.tick(20_000);
  answer({ data: { id: asked[0].id, result: "seen" } });
  answer({ data: { id: asked[1].id, result: "found" } });
  assert.deepEqual(await Promise.all([sighting, detection]), ["seen", "found"]);
});

test("a worker that answers no frame is reported after four seconds", async () => {
  const detection = new Detector().detect(frame());
  mock.timers.tick(3_999);
  const outcome = assert.rejects(detection, /does not answer/);
  mock.timers.tick(2);
  await outcome;
});

test("a worker that never opens is reported after twenty seconds", async (t) => {
  t.mock.method(globalThis, "fetch", async () => Response.json({ bytes: 1 }));
  const outcome = assert.rejects(Detector.open({}), /does not answer/);
  while (asked.length === 0) await new Promise(setImmediate);
  mock.timers.tick(20_001);
  await outcome;
});
