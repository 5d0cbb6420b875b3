import assert from "node:assert/strict";
import { test } from "node:test";
import { countsOf } from "../../web/landing/counts.js";
import { BITS } from "../../web/landing/capture-loop.js";
import { DEFAULT_BOARD, markers } from "../../web/lib/board.js";
import { markerBits } from "../../web/lib/board-drawing.js";

test("cameras and those ready at any size are counted", () => {
  const size = (reliable, calibrations) => ({ reliable, calibrations });
  const cameras = [
    { sizes: [size(true, 6), size(false, 2)] },
    { sizes: [size(false, 1)] },
    { sizes: [size(true, 5), size(true, 7)] },
  ];
  assert.deepEqual(countsOf(cameras, false), { cameras: 3, ready: 2, calibrations: 21, more: false });
  assert.deepEqual(countsOf([], false), { cameras: 0, ready: 0, calibrations: 0, more: false });
});

test("the board of the loop has the markers of the default board", () => {
  const bits = markers(DEFAULT_BOARD).map(({ id }) =>
    markerBits(DEFAULT_BOARD.dictionary, id)
      .flat()
      .reduce((all, bit) => 2 * all + Number(bit), 0)
      .toString(16)
      .padStart(4, "0"),
  );
  assert.equal(BITS, bits.join(""));
});
