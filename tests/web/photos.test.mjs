import assert from "node:assert/strict";
import { test } from "node:test";
import { UnreadableError } from "../../web/photos/files.js";
import { cameraName, readExif, unturned } from "../../web/photos/exif.js";
import { groups } from "../../web/photos/group.js";
import { questionOf } from "../../web/photos/likely.js";
import { rankByNovelty, sortByGain } from "../../web/lib/rank.js";
import { calibrate } from "../../web/lib/series.js";
import { playedFrames } from "../../web/photos/video-frames.js";
import { DEFAULT_BOARD } from "../../web/lib/board.js";
import { drawnBoard } from "../../web/photos/wanted.js";
import { Sessions } from "./sessions.mjs";
import { setGlobals } from "./globals.mjs";
import { PINHOLE, isInside, targetOf } from "./scenes.mjs";

/** EXIF of a Canon EOS R6, turned by a quarter, at 24.3 mm. @param {boolean} little its byte order */
function tiff(little) {
  const bytes = new DataView(new ArrayBuffer(400));
  let free = 200;
  const entry = (at, tag, type, count, value) => {
    bytes.setUint16(at, tag, little);
    bytes.setUint16(at + 2, type, little);
    bytes.setUint32(at + 4, count, little);
    if (type === 3) bytes.setUint16(at + 8, value, little);
    else bytes.setUint32(at + 8, value, little);
  };
  const words = (at, tag, text) => {
    entry(at, tag, 2, text.length + 1, free);
    for (const character of `${text}\0`) bytes.setUint8(free++, character.charCodeAt(0));
  };
  bytes.setUint16(0, little ? 0x4949 : 0x4d4d);
  bytes.setUint16(2, 42, little);
  bytes.setUint32(4, 8, little);
  bytes.setUint16(8, 4, little);
  words(10, 0x010f, "Canon");
  words(22, 0x0110, "Canon EOS R6");
  entry(34, 0x0112, 3, 1, 6);
  entry(46, 0x8769, 4, 1, 80);
  bytes.setUint16(80, 2, little);
  bytes.setUint32(300, 243, little);
  bytes.setUint32(304, 10, little);
  entry(82, 0x920a, 5, 1, 300);
  words(94, 0xa434, "RF24-70mm F2.8 L IS USM");
  return new Uint8Array(bytes.buffer);
}
const joined = (...parts) =>
  Uint8Array.from(
    parts.flatMap((part) => (typeof part === "string" ? [...part].map((c) => c.charCodeAt(0)) : [...part])),
  ).buffer;
const big = (value) => [value >>> 24, (value >>> 16) & 255, (value >>> 8) & 255, value & 255];
const jpeg = (block) =>
  joined(
    [0xff, 0xd8, 0xff, 0xe0, 0, 4, 1, 2, 0xff, 0xe1],
    big(block.length + 8).slice(2),
    "Exif\0\0",
    block,
    [0xff, 0xda, 0, 2],
  );

test("EXIF is read in every format and byte order", () => {
  for (const little of [true, false]) {
    const block = tiff(little);
    const files = {
      jpeg: jpeg(block),
      tiff: joined(block),
      png: joined(
        [0x89, 0x50, 0x4e, 0x47, 13, 10, 26, 10],
        big(0),
        "IHDR",
        big(0),
        big(block.length),
        "eXIf",
        block,
        big(0),
      ),
      webp: joined(
        "RIFF",
        [0, 0, 0, 0],
        "WEBP",
        "VP8 ",
        [3, 0, 0, 0],
        [1, 2, 3, 0],
        "EXIF",
        big(block.length).reverse(),
        block,
      ),
    };
    for (const [format, file] of Object.entries(files)) {
      const exif = readExif(file);
      assert.equal(cameraName(exif), "Canon EOS R6, RF24-70mm F2.8 L IS USM", `${format} ${little}`);
      assert.equal(exif.focal, 24.3);
      assert.equal(exif.orientation.value, 6);
    }
  }
});

test("a turned photograph is turned back to the sensor's rows", () => {
  const file = jpeg(tiff(true));
  const exif = readExif(file);
  const straight = unturned(file, exif);
  assert.equal(readExif(straight).orientation.value, 1);
  assert.equal(readExif(file).orientation.value, 6);
  assert.equal(unturned(straight, readExif(straight)), straight);
});

test("files that are cut, empty or of nobody's are read without a word", () => {
  const file = jpeg(tiff(false));
  for (let length = 0; length < file.byteLength; length += 7)
    assert.equal(typeof readExif(file.slice(0, length)).model, "string");
  assert.equal(cameraName(readExif(new ArrayBuffer(50))), "");
  const wild = new DataView(file.slice(0));
  wild.setUint32(24, 0xfffffff0); // the first directory far outside
  assert.equal(readExif(wild.buffer).model, "");
});

test("names are said as people say them", () => {
  const of = (make, model, lens = "") => cameraName({ make, model, lens, focal: 0, orientation: null });
  assert.equal(of("GoPro", "HERO9 Black"), "GoPro HERO9 Black");
  assert.equal(of("NIKON CORPORATION", "NIKON Z 6"), "NIKON Z 6");
  assert.equal(of("", ""), "");
});

const picture = (more) => ({
  camera: "A",
  focal: 0,
  kind: "photographs",
  size: [640, 480],
  ids: [0, 1, 2, 3, 4, 5, 6],
  points: [],
  outline: null,
  ...more,
});

test("photographs of different sizes, lenses or zooms are never mixed", () => {
  const found = groups([
    picture(),
    picture({ size: [480, 640] }),
    picture(),
    picture({ focal: 35 }),
    picture({ camera: "B" }),
    picture({ ids: [1, 2] }),
  ]);
  assert.deepEqual(
    found.map(({ members }) => members),
    [[0, 2], [1], [3], [4]],
  );
});

test("the photograph that shows something new comes first, the copy last", () => {
  const square = (x, y, side, tilt = 0) => [
    [x, y],
    [x + side, y],
    [x + side - tilt, y + side],
    [x + tilt, y + side],
  ];
  const at = (x, y, side, tilt) => ({ outline: square(x, y, side, tilt), points: square(x, y, side, tilt) });
  const [flat, tilted, corner, copy] = [
    at(200, 100, 200),
    at(200, 100, 220, 60),
    at(420, 260, 200, 20),
    at(201, 101, 200),
  ];
  const order = rankByNovelty([flat, copy, corner, tilted], [640, 480]);
  assert.equal(order[0], tilted);
  assert.equal(order[1], corner);
  assert.ok([flat, copy].includes(order[3]));
});

/** A service that refuses view 1 until it has taken two, and never takes view 5. */
function service() {
  const sessions = new Sessions();
  sessions.judge = (id, taken) => (id === 5 ? "degenerate" : id === 1 && taken < 2 ? "outlier" : null);
  return sessions;
}
const views = [0, 1, 5, 2, 3].map((id) => ({ ids: [id], points: [[id, id]] }));
const request = { camera: "A", platform: "photographs", img_size: [1280, 720] };

test("every view that agrees counts, however little it adds", async () => {
  const sessions = service();
  const judged = [];
  const { state, wanted, numbers } = await calibrate(sessions.api, "t", request, views, (judgement) =>
    judged.push(judgement),
  );
  assert.deepEqual([state.status, state.calibration_id], ["converged", "id"], "a poor result is kept for its maker");
  assert.deepEqual(
    [...numbers],
    [
      [0, 0],
      [1, 3],
      [2, 4],
      [3, 1],
    ],
  );
  assert.deepEqual(wanted, { index: 4 });
  assert.equal(sessions.bodies("POST /session")[0].capture, "recorded");
  assert.deepEqual(
    judged.filter(({ accepted }) => accepted).map(({ view, before, after }) => [view, before, after]),
    [
      [0, null, 3],
      [3, 3, 1],
      [4, 1, 0.5],
      [1, 0.5, 40],
    ],
  );
  assert.equal(judged.filter(({ view }) => view === 2).length, 1, "what no other view can mend is offered once");
  assert.equal(sessions.bodies("POST /session/batch").length, 2);
});

test("views for which a request has no time are sent in the next", async () => {
  const sessions = service();
  sessions.most = 2;
  const judged = [];
  await calibrate(sessions.api, "t", request, views, (judgement) => judged.push(judgement.view));
  const batches = sessions
    .bodies("POST /session/batch")
    .map(({ index, views: sent }) => [index, sent.map(({ ids }) => ids[0])]);
  assert.deepEqual(batches, [
    [0, [0, 1, 5, 2, 3]],
    [1, [5, 2, 3]],
    [2, [3]],
    [3, [1]],
  ]);
  assert.deepEqual(judged, [0, 1, 2, 3, 4, 1]);
});

test("what was used is shown first, in the order in which the error fell", () => {
  const judgements = {
    a: undefined,
    b: { accepted: true, after: 0.3 },
    c: { accepted: false, after: null },
    d: { accepted: true, after: 2 },
    e: { accepted: true, after: null },
  };
  assert.deepEqual(
    sortByGain(["a", "b", "c", "d", "e"], (name) => judgements[name]),
    ["e", "d", "b", "a", "c"],
  );
});

test("views that are too few are not stored; what would help is asked for", async () => {
  const { api } = service();
  const { state, wanted } = await calibrate(api, "t", request, views.slice(0, 3), () => {});
  assert.equal(state.calibration_id, null);
  assert.deepEqual(wanted, { index: 1 });
});

test("unreadable files are classified by type, then name", () => {
  const codes = [
    ["a.HEIC", ""],
    ["b.nef", "image/x-nikon-nef"],
    ["c.mov", ""],
    ["d.webm", "video/webm"],
    ["e.jpg", "image/jpeg"],
    ["f.txt", "text/plain"],
  ];
  assert.deepEqual(
    codes.map(([name, type]) => new UnreadableError({ name, type }).code),
    ["heic", "raw", "video", "video", "image", "other"],
  );
});

test("the first photo that names its camera is looked up", () => {
  const nameless = picture({ camera: "", ids: [] });
  const phone = { ...nameless, camera: "Apple iPhone 13", focal: 5.1, focal35: 26, size: [4032, 3024] };
  assert.equal(questionOf([nameless, { ...phone, kind: "video" }]), null);
  assert.deepEqual(questionOf([nameless, phone]), {
    camera: "Apple iPhone 13",
    platform: "photographs",
    img_size: [4032, 3024],
    zoom: 5.1,
    reported: { focal_35mm: 26 },
    redirect: false,
    miss: "ok",
  });
  assert.equal("reported" in questionOf([{ ...phone, focal35: 0 }]), false);
});

const SCREEN_HZ = 60;

/** A video of `count` frames; rate and what the browser decodes (capacity) in frames/s. */
function film({ rate, count, capacity }) {
  const listeners = {};
  const video = {
    duration: count / rate,
    playbackRate: 1,
    currentTime: 0,
    paused: true,
    played: 0,
    addEventListener: (name, call) => (listeners[name] = call),
    requestVideoFrameCallback: (call) => (video.callback = call),
    pause: () => (video.paused = true),
    play: async () => {
      video.paused = false;
    },
  };
  let [at, lastFrame, budget] = [0, 0, 0];
  const tick = () => {
    if (video.paused) return;
    video.played += 1 / SCREEN_HZ;
    at += video.playbackRate / SCREEN_HZ;
    budget = Math.min(1, budget + capacity / SCREEN_HZ);
    const frame = Math.floor(at * rate);
    if (frame >= count) return listeners.ended?.();
    if (frame === lastFrame || budget < 1) return;
    [lastFrame, budget] = [frame, budget - 1];
    const call = video.callback;
    video.callback = null;
    call?.(0, { mediaTime: frame / rate });
  };
  return { video, tick };
}

/** One refresh of the screen is needed to look at a picture. */
async function watch(t, options) {
  const { video, tick } = film(options);
  const document = { hidden: false, addEventListener() {} };
  setGlobals(t, { document, createImageBitmap: async () => ({ close() {} }) });
  const times = [];
  const timer = setInterval(tick, 0);
  for await (const { time } of playedFrames(video, 120, new AbortController().signal)) {
    times.push(time);
    const until = video.played + 1 / SCREEN_HZ;
    while (video.played < until && !video.paused) await new Promise(setImmediate);
  }
  clearInterval(timer);
  return { times, played: video.played };
}

test("a long video is played faster without losing frames", async (t) => {
  const { times, played } = await watch(t, { rate: 24, count: 260, capacity: 60 });
  assert.ok(times.length >= 116, `${times.length} frames`);
  assert.ok(played < 0.6 * (260 / 24), `${played} s`);
});

test("a browser that misses frames is given the time that it needs", async (t) => {
  const { times } = await watch(t, { rate: 6, count: 57, capacity: 14 });
  assert.ok(times.length >= 54, `${times.length} frames of 57`);
  assert.equal(new Set(times).size, times.length);
});

const POSE = { rvec: [0.3, -0.4, 0.05], tvec: [-5.5, -3.5, 9] };
/** A lens whose model folds the edge of the board back: a fit of few views may say that. */
const FOLDING = { ...PINHOLE, fx: 900, fy: 900, k1: -0.5, k2: 0.1 };

for (const board of [
  DEFAULT_BOARD,
  { ...DEFAULT_BOARD, squares: [4, 5], inverted: true },
  { ...DEFAULT_BOARD, kind: "chessboard", squares: [9, 7] },
]) {
  test(`the squares and markers of a drawn board lie within its rim: ${JSON.stringify(board)}`, () => {
    const pose = targetOf(board, FOLDING, POSE);
    const { rim, black } = drawnBoard(board, pose);
    const centres = black.map((polygon) =>
      [0, 1].map((k) => polygon.reduce((sum, point) => sum + point[k], 0) / polygon.length),
    );
    assert.ok(centres.every((centre) => isInside(centre, rim)));
    assert.ok(pose.corners.every((corner) => isInside(corner, rim)));
    assert.ok(black.length > (board.kind === "chessboard" ? 30 : 100));
    const some = pose.ids.filter((id) => id % 5 !== 0);
    const part = drawnBoard(board, { ...pose, ids: some, corners: some.map((id) => pose.corners[id]) });
    assert.equal(part.black.length, black.length);
  });
}
