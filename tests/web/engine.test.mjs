import assert from "node:assert/strict";
import { test } from "node:test";
import { DEFAULT_BOARD } from "../../web/lib/board.js";
import { Engine } from "../../web/lib/capture/engine.js";
import { Detector, DetectorError, PageDetector } from "../../web/lib/detector.js";
import { BLIND, observeFrame } from "../../web/lib/capture/sight.js";
import { Feedback } from "../../web/lib/capture/feedback.js";
import { colour } from "../../web/calibrate/tint.js";
import { latest } from "../../web/lib/latest.js";
import { Sharpest } from "../../web/lib/rank.js";
import { METRICS } from "./scenes.mjs";
import { inTurn, setGlobals } from "./globals.mjs";

const SIZE = [1280, 720];
const IDS = Array.from({ length: 40 }, (_, id) => id);
const detection = ({ shift = 0, sharpness = 0.15, size = SIZE } = {}) => ({
  ids: IDS,
  points: IDS.map((id) => [200 + 60 * (id % 8) + shift, 150 + 60 * Math.floor(id / 8)]),
  markers: 24,
  size,
  metrics: { ...METRICS, share: 1, sharpness, square: 60, moire: 0 },
});

/** A stream of one camera or of two that share it. */
function streamOf(count = 1) {
  const stream = {
    video: { requestVideoFrameCallback: (done) => setTimeout(done, 20) },
    unchanged: true,
    open: 0,
    locked: 0,
    camera: { track: { getSettings: () => ({}), getCapabilities: () => ((stream.locked += 1), {}) } },
    grab: async () => Array.from({ length: count }, () => ((stream.open += 1), { close: () => (stream.open -= 1) })),
  };
  return stream;
}

/** A detector that gives what `answers` has, and closes its images; the last answer again and again. */
const detectorOf = (...answers) => ({
  closed: false,
  close() {
    this.closed = true;
  },
  async detect(image, options) {
    image.close();
    this.options = options;
    return inTurn(answers);
  },
});

function pageOf(t, rounds, more = {}) {
  setGlobals(t, { document: { hidden: false } });
  const log = [];
  const sights = new Map();
  const page = {
    log,
    isOver: () => rounds <= 0,
    sight: (camera) => sights.get(camera) ?? BLIND,
    observe: (camera, found) => {
      sights.set(camera, observeFrame(page.sight(camera), found, performance.now(), DEFAULT_BOARD));
      log.push(`seen ${camera.half}`);
    },
    act: async () => {
      rounds -= 1;
      log.push("act");
    },
    isSearched: () => false,
    suggest: () => {},
    onStalled: (stalled) => log.push(stalled ? "stalled" : "again"),
    onResized: () => {
      log.push("resized");
      rounds = 0;
    },
    ...more,
  };
  return page;
}

/** Parts of a page that looks on for so long, ms. */
function lasting(ms) {
  const start = performance.now();
  return { isOver: () => performance.now() - start > ms, act: async () => {} };
}

/** A single camera. */
const only = (stream) => [{ stream, half: 0 }];

const engineOf = (page, cameras, ...detectors) =>
  new Engine(page, {
    cameras,
    board: () => DEFAULT_BOARD,
    openDetector: async () => detectors.shift() ?? assert.fail("another detector"),
    signal: new AbortController().signal,
  });

test("each camera is looked at in each round, and no image is left open", async (t) => {
  const [pair, single] = [streamOf(2), streamOf()];
  const cameras = [
    { stream: pair, half: 0 },
    { stream: pair, half: 1 },
    { stream: single, half: 0 },
  ];
  const page = pageOf(t, 2);
  await engineOf(page, cameras, detectorOf(detection())).run();
  assert.deepEqual(page.log, [...["seen 0", "seen 1", "seen 0", "act"], ...["seen 0", "seen 1", "seen 0", "act"]]);
  // The detector closes an image, and the engine does so again, which does nothing in a browser.
  assert.ok(pair.open <= 0 && single.open <= 0);
});

test("the fourth failure of a detector ends the capture", async (t) => {
  const made = Array.from({ length: 4 }, () => detectorOf(new DetectorError("gone")));
  const page = pageOf(t, 1);
  await assert.rejects(engineOf(page, only(streamOf()), ...made).run(), DetectorError);
  assert.deepEqual(page.log, ["stalled", "again", "stalled", "again", "stalled", "again"]);
  assert.deepEqual(
    made.map(({ closed }) => closed),
    [true, true, true, false],
  );
});

test("a turned device is reported before its images are looked at", async (t) => {
  const page = pageOf(t, 1);
  await engineOf(page, only({ ...streamOf(), unchanged: false }), detectorOf(detection())).run();
  assert.deepEqual(page.log, ["resized"]);
});

test("a view with a jerk, blur or another size is refused", async (t) => {
  const taken = async (view, lenience) => {
    const camera = { stream: streamOf(), half: 0 };
    const detector = detectorOf(detection(), detection(), view);
    let found;
    const page = pageOf(t, 2);
    const act = page.act;
    const engine = engineOf(page, [camera], detector);
    page.act = async () => {
      await act();
      if (page.isOver()) found = await engine.take(camera, lenience ? { lenience: () => lenience } : {});
    };
    await engine.run();
    assert.equal(detector.options.full, true);
    return { found, log: page.log };
  };
  assert.deepEqual((await taken(detection({ shift: 2.9 }))).found.corners.ids, IDS);
  assert.equal((await taken(detection({ shift: 3.1 }))).found, null);
  assert.ok((await taken(detection({ shift: 3.1 }), 2)).found);
  assert.equal((await taken(detection({ sharpness: 0.1 }))).found, null);
  assert.deepEqual((await taken(detection({ size: [720, 1280] }))).log.slice(-1), ["resized"]);
});

test("focus is locked once, after a hold", async (t) => {
  const stream = streamOf();
  let focused = 0;
  const page = pageOf(t, 0, { ...lasting(600), onFocused: () => (focused += 1) });
  await engineOf(page, only(stream), detectorOf(detection())).run();
  assert.deepEqual([stream.locked, focused], [1, 1]);
});

test("other boards are searched while no corner is seen", async (t) => {
  const searched = async (found, isSearched) => {
    const detector = detectorOf(found);
    let looks = 0;
    detector.sight = async (image) => {
      image.close();
      looks += 1;
      return { family: null, markers: [], inverted: false, mirrored: false, size: SIZE, chessboard: null };
    };
    const suggestions = [];
    const page = pageOf(t, 0, {
      ...lasting(800),
      isSearched: () => isSearched,
      suggest: (_, suggestion) => suggestions.push(suggestion),
    });
    await engineOf(page, only(streamOf()), detector).run();
    assert.equal(suggestions.length, looks);
    return suggestions;
  };
  const blind = { ...detection(), ids: [], points: [], markers: 0 };
  const suggestions = await searched(blind, true);
  assert.ok(suggestions.length > 0 && suggestions.every((each) => each === null));
  assert.deepEqual(await searched(blind, false), []);
  assert.deepEqual(await searched(detection(), true), []);
});

test("the detector is opened once, and again after a failure", async () => {
  const made = [];
  const detector = new PageDetector(async () => {
    const one = { closed: false, close: () => (one.closed = true) };
    if (made.push(one) === 2) throw new DetectorError("not loaded");
    return one;
  });
  const first = await detector.open();
  assert.equal(await detector.open(), first);
  detector.close();
  await assert.rejects(detector.open(), DetectorError);
  assert.ok(first.closed && (await detector.open()) === made[2]);
  assert.equal(made.length, 3);
});

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
