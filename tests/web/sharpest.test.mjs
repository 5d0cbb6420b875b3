import assert from "node:assert/strict";
import { test } from "node:test";
import { Sharpest } from "../../web/lib/rank.js";

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
