import assert from "node:assert/strict";
import { test } from "node:test";
import { MOVING, motion, observe } from "../../web/lib/capture/stillness.js";

const at = (x) => ({ ids: [0, 1, 2, 3, 4], points: [0, 1, 2, 3, 4].map((i) => [x + 50 * i, 100]) });

/** Positions at 20 frames a second. */
const watch = (positions, width = 1280) =>
  positions.reduce((state, x, index) => observe(state, at(x), 50 * index, width), MOVING);

test("a steady hand is held since its first frame", () => {
  const { held, frames } = watch([100, 101, 100, 99.5, 100.5, 100]);
  assert.deepEqual([held, frames], [250, 5]);
});

test("a jump begins a new hold, once it lasts", () => {
  const { held, frames } = watch([100, 100, 100, 104, 104, 104, 104]);
  assert.deepEqual([held, frames], [50, 1]);
});

test("slow movement is movement: 1.5 px a frame never makes a long hold", () => {
  let state = MOVING;
  for (let index = 0; index < 100; index++) {
    state = observe(state, at(100 + 1.5 * index), 50 * index, 1280);
    assert.ok(state.held <= 200, `held ${state.held} ms`);
  }
});

test("the limit scales with the width of the image", () => {
  assert.equal(watch([100, 101.5, 100], 1280).frames, 2);
  assert.equal(watch([100, 101.5, 100], 640).frames, 0);
});

test("a smeared frame is passed over in a hold, not before one, and not for long", () => {
  const held = watch([100, 100, 100]);
  const nothing = { ids: [], points: [] };
  const passed = observe(held, nothing, 150, 1280);
  assert.equal(passed, held, "the very same: nothing was learnt");
  assert.equal(observe(passed, at(100), 200, 1280).held, 200);
  assert.equal(observe(passed, at(108), 200, 1280), held);
  assert.equal(observe(passed, at(108), 250, 1280).held, 0, "that is movement");
  assert.equal(observe(watch([100]), nothing, 50, 1280).anchor, nothing);
});

test("time that no frame shows does not count as held", () => {
  const every = (gap) => [0, 1, 2, 3].reduce((state, index) => observe(state, at(100), gap * index, 1280), MOVING);
  assert.equal(every(250).held, 750);
  assert.equal(every(600).held, 750, "of a device that looks twice a second");
  assert.equal(every(600).seen, 1800);
});

test("too few common corners are no evidence of stillness", () => {
  const few = {
    ids: [0, 1, 7, 8],
    points: [
      [0, 0],
      [1, 0],
      [2, 0],
      [3, 0],
    ],
  };
  assert.equal(motion(at(0), few), Infinity);
  assert.equal(observe(watch([100, 100]), few, 200, 1280).held, 0);
  assert.equal(observe(watch([100, 100]), { ids: [], points: [] }, 200, 1280).held, 0);
});
