import assert from "node:assert/strict";
import { test } from "node:test";
import { refine, refineCorner, squareSizes } from "../../web/lib/subpixel.js";
import { DEFAULT_BOARD } from "../../web/lib/board.js";
import { markerBits } from "../../web/lib/board-drawing.js";
import { cornersSeen, photograph, rectangle } from "./scenes.mjs";
import { readMarkers } from "../../web/lib/marker-reader.js";

const SIZE = [640, 360];
const LENS = { fx: 500, fy: 505, cx: 327.3, cy: 172.8, k1: -0.25, k2: 0.05, p1: 0.001, p2: -0.002, k3: 0 };

function scene(pose) {
  return { image: photograph(DEFAULT_BOARD, LENS, SIZE, pose), ...cornersSeen(DEFAULT_BOARD, LENS, pose) };
}

const POSE = { rvec: [0.3, -0.4, 0.1], tvec: [-4.2, -2.9, 9] };

test("corners that start up to 0.8 px away come back to 0.1 px rms", () => {
  const { image, points, ids } = scene(POSE);
  const started = points.map(([x, y], index) => [x + 0.8 * Math.cos(index), y + 0.8 * Math.sin(index)]);
  const { ids: kept, points: refined } = refine(image, { ids, points: started }, 8);
  assert.equal(kept.length, 40);
  const errors = refined.map(([x, y], index) => Math.hypot(x - points[index][0], y - points[index][1]));
  const rms = Math.sqrt(errors.reduce((sum, error) => sum + error ** 2, 0) / errors.length);
  assert.ok(rms < 0.1, `rms ${rms.toFixed(3)} px`);
  assert.ok(Math.max(...errors) < 0.2, `max ${Math.max(...errors).toFixed(3)} px`);
});

test("a corner that is not there is dropped", () => {
  const { image, points, ids } = scene(POSE);
  const wrong = points.map((point) => [...point]);
  wrong[11][0] += 3; // more than the 1 px that a detector may be wrong by
  assert.ok(!refine(image, { ids, points: wrong }, 8).ids.includes(11));
});

test("corners of squares below 16 px are dropped", () => {
  const { image, points, ids } = scene({ rvec: [0, 0, 0], tvec: [-4.5, -3, 36] });
  assert.deepEqual(refine(image, { ids, points }, 8).ids, []);
});

test("a flat patch and the image's edge hold no corner", () => {
  const image = { width: 64, height: 64, data: new Uint8Array(64 * 64).fill(90) };
  assert.equal(refineCorner(image, 30, 30, 4), null);
  assert.equal(refineCorner(image, 2, 30, 4), null);
});

test("squares are measured between neighbours", () => {
  // Corners 7 and 8 of a board of 8 a row follow each other by number and lie at opposite ends.
  assert.deepEqual(
    squareSizes(
      [7, 8, 15],
      [
        [400, 100],
        [50, 140],
        [400, 140],
      ],
      8,
    ),
    [40, 40, 40],
  );
});

const CELL = 12; // px

/** A marker drawn on white, turned by quarters and mirrored, and the quadrilateral of its outermost black pixels. */
function drawn(family, id, { border = 1, quarters = 0, mirrored = false } = {}) {
  let cells = markerBits(family, id);
  for (let n = 0; n < quarters; n++) cells = cells[0].map((_, column) => cells.map((row) => row[column]).reverse());
  if (mirrored) cells = cells.map((row) => [...row].reverse());
  const count = cells.length + 2 * border;
  const [width, from] = [CELL * (count + 4), 2 * CELL];
  const data = new Uint8Array(width * width).fill(220);
  for (let y = 0; y < count * CELL; y++) {
    for (let x = 0; x < count * CELL; x++) {
      const white = cells[Math.floor(y / CELL) - border]?.[Math.floor(x / CELL) - border] ?? false;
      data[(from + y) * width + from + x] = white ? 220 : 30;
    }
  }
  return {
    image: { width, height: width, data },
    quad: rectangle(from, from, count * CELL - 1),
  };
}

test("a marker is read turned, mirrored and with Kalibr's border", () => {
  for (const [family, id, border] of [
    ["DICT_4X4_1000", 7, 1],
    ["DICT_6X6_1000", 123, 1],
    ["DICT_APRILTAG_36h11", 31, 2],
    ["DICT_7X7_1000", 900, 1],
  ]) {
    for (const quarters of [0, 1, 2, 3]) {
      for (const mirrored of [false, true]) {
        const { image, quad } = drawn(family, id, { border, quarters, mirrored });
        const own = readMarkers(image, [quad]).filter((each) => each.family === family && each.mirrored === mirrored);
        assert.deepEqual(
          own.flatMap(({ markers }) => markers.map((marker) => marker.id)),
          [id],
          `${family} ${quarters} ${mirrored}`,
        );
        assert.equal(own[0].border, border);
      }
    }
  }
});

test("the first corner is the marker's own upper left", () => {
  const { image, quad } = drawn("DICT_5X5_1000", 3, { quarters: 1 });
  const [reading] = readMarkers(image, [quad]);
  const [[x, y]] = reading.markers[0].corners;
  assert.ok(Math.hypot(x - quad[1][0] - 0.5, y - quad[1][1] + 0.5) < 0.5, "a quarter clockwise: at the upper right");
  const other = drawn("DICT_5X5_1000", 3, { mirrored: true });
  const back = readMarkers(other.image, [other.quad]).find(({ mirrored }) => mirrored);
  const [[u, v]] = back.markers[0].corners;
  assert.ok(Math.hypot(u - quad[0][0] + 0.5, v - quad[0][1] + 0.5) < 0.5);
});

test("what has no dark frame, or no contrast, is not a marker", () => {
  const { image, quad } = drawn("DICT_4X4_1000", 7);
  assert.deepEqual(readMarkers({ ...image, data: image.data.map((value) => 255 - value) }, [quad]), []);
  assert.deepEqual(readMarkers({ ...image, data: image.data.map((value) => 100 + value / 20) }, [quad]), []);
});
