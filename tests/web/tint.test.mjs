import assert from "node:assert/strict";
import { test } from "node:test";
import { colour } from "../../web/calibrate/tint.js";

test("green and magenta become the target's colour, the one more of it than the other; black stays black", () => {
  const data = new Uint8ClampedArray([0, 255, 0, 255, 255, 0, 255, 255, 0, 0, 0, 255]);
  colour(data);
  assert.deepEqual([...data], [255, 176, 0, 255, 184, 153, 102, 255, 0, 0, 0, 255]);
});
