import assert from "node:assert/strict";
import { test } from "node:test";
import { countsOf } from "../../web/landing/counts.js";

test("cameras of the database are counted once, those that a lookup answers at any size apart", () => {
  const size = (reliable, calibrations) => ({ reliable, calibrations });
  const cameras = [{ sizes: [size(true, 6), size(false, 2)] }, { sizes: [size(false, 1)] }, { sizes: [size(true, 5), size(true, 7)] }];
  assert.deepEqual(countsOf(cameras, false), { cameras: 3, ready: 2, calibrations: 21, more: false });
  assert.deepEqual(countsOf([], false), { cameras: 0, ready: 0, calibrations: 0, more: false });
});
