import assert from "node:assert/strict";
import { test } from "node:test";
import { UnreadableError } from "../../web/photos/files.js";
import { cameraName, readExif, unturned } from "../../web/photos/exif.js";
import { groups } from "../../web/photos/group.js";
import { questionOf } from "../../web/photos/likely.js";
import { sortByGain, rankByNovelty } from "../../web/lib/rank.js";
import { calibrate } from "../../web/lib/series.js";
import { Sessions } from "./sessions.mjs";

function tiff({
  little,
  make = "Canon",
  model = "Canon EOS R6",
  lens = "RF24-70mm F2.8 L IS USM",
  orientation = 6,
  focal = [243, 10],
}) {
  const bytes = new DataView(new ArrayBuffer(400));
  let free = 200;
  const ascii = (text) => {
    [...`${text}\0`].forEach((character, index) => bytes.setUint8(free + index, character.charCodeAt(0)));
    free += text.length + 1;
    return free - text.length - 1;
  };
  const entry = (at, tag, type, count, value) => {
    bytes.setUint16(at, tag, little);
    bytes.setUint16(at + 2, type, little);
    bytes.setUint32(at + 4, count, little);
    if (type === 3) bytes.setUint16(at + 8, value, little);
    else bytes.setUint32(at + 8, value, little);
  };
  bytes.setUint16(0, little ? 0x4949 : 0x4d4d);
  bytes.setUint16(2, 42, little);
  bytes.setUint32(4, 8, little);
  bytes.setUint16(8, 4, little);
  entry(10, 0x010f, 2, make.length + 1, ascii(make));
  entry(22, 0x0110, 2, model.length + 1, ascii(model));
  entry(34, 0x0112, 3, 1, orientation);
  entry(46, 0x8769, 4, 1, 80);
  bytes.setUint16(80, 2, little);
  bytes.setUint32(free + 2, focal[0], little);
  bytes.setUint32(free + 6, focal[1], little);
  entry(82, 0x920a, 5, 1, free + 2);
  free += 12;
  entry(94, 0xa434, 2, lens.length + 1, ascii(lens));
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
    const block = tiff({ little });
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
  const file = jpeg(tiff({ little: true }));
  const exif = readExif(file);
  const straight = unturned(file, exif);
  assert.equal(readExif(straight).orientation.value, 1);
  assert.equal(readExif(file).orientation.value, 6);
  assert.equal(unturned(straight, readExif(straight)), straight);
});

test("files that are cut, empty or of nobody's are read without a word", () => {
  const file = jpeg(tiff({ little: false }));
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
  name: "a",
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
function service(errors) {
  const sessions = new Sessions();
  sessions.errors = errors;
  sessions.judge = (id, taken) => (id === 5 ? "degenerate" : id === 1 && taken < 2 ? "outlier" : null);
  return sessions;
}
const views = [0, 1, 5, 2, 3].map((id) => ({ ids: [id], points: [[id, id]] }));
const request = { camera: "A", platform: "photographs", img_size: [1280, 720] };

test("every view that agrees counts, however little it adds", async () => {
  const sessions = service([3, 1, 0.5, 40]);
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
  const sessions = service([3, 1, 0.5, 0.5]);
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
  const { api } = service([9, 7, 5]);
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
  const phone = { ...nameless, name: "b", camera: "Apple iPhone 13", focal: 5.1, focal35: 26, size: [4032, 3024] };
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
