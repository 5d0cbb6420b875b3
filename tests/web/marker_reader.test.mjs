import assert from "node:assert/strict";
import { test } from "node:test";
import { markerBits } from "../../web/lib/board-drawing.js";
import { readMarkers } from "../../web/lib/marker-reader.js";

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
  const [low, high] = [from, from + count * CELL - 1];
  return {
    image: { width, height: width, data },
    quad: [
      [low, low],
      [high, low],
      [high, high],
      [low, high],
    ],
  };
}

test("a marker is read in every turn, mirrored, and with the border that Kalibr prints", () => {
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

test("the first corner is the marker's own upper left, in the picture turned back where it is mirrored", () => {
  const { image, quad } = drawn("DICT_5X5_1000", 3, { quarters: 1 });
  const [reading] = readMarkers(image, [quad]);
  const [[x, y]] = reading.markers[0].corners;
  assert.ok(Math.hypot(x - quad[1][0] - 0.5, y - quad[1][1] + 0.5) < 0.5, "a quarter clockwise: at the upper right");
  const other = drawn("DICT_5X5_1000", 3, { mirrored: true });
  const back = readMarkers(other.image, [other.quad]).find(({ mirrored }) => mirrored);
  const [[u, v]] = back.markers[0].corners;
  assert.ok(Math.hypot(u - quad[0][0] + 0.5, v - quad[0][1] + 0.5) < 0.5);
});

test("what has no dark frame, or no contrast, is no marker", () => {
  const { image, quad } = drawn("DICT_4X4_1000", 7);
  assert.deepEqual(readMarkers({ ...image, data: image.data.map((value) => 255 - value) }, [quad]), []);
  assert.deepEqual(readMarkers({ ...image, data: image.data.map((value) => 100 + value / 20) }, [quad]), []);
});
