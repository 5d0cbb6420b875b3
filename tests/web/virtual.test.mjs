import assert from "node:assert/strict";
import { test } from "node:test";
import { labelOf, setupFrom } from "../../web/lib/virtual/setup.js";
import { DEFAULT_BOARD, corners } from "../../web/lib/board.js";
import { HANDS, Hand } from "../../web/lib/virtual/hand.js";
import { matchPose } from "../../web/lib/virtual/match.js";
import { PINHOLE, distances, rms, see, targetOf } from "./scenes.mjs";

test("an address sets the truth, and another truth is another camera", () => {
  const [one, same, other] = ["k1=-0.25&error=0.5", "k1=-0.25&seed=9", "k1=-0.26&error=0.5"].map((more) =>
    setupFrom(new URLSearchParams(`virtual=1&fx=1000&cx=664.5&k2=0&${more}`)),
  );
  const { fx, fy, cx, k1, k2 } = one.lens;
  assert.deepEqual([fx, fy, cx, k1, k2, one.error], [1000, 1000, 664.5, -0.25, 0, 0.5]);
  assert.notEqual(labelOf(one), labelOf(other));
  assert.equal(labelOf(one), labelOf(same));
});

test("an address sets the frame rate within limits", () => {
  const rate = (address) => setupFrom(new URLSearchParams(address)).rate;
  assert.deepEqual(["", "rate=10", "rate=0", "rate=1e9", "rate=x"].map(rate), [30, 10, 2, 60, 30]);
});

const LENS = { ...PINHOLE, fx: 640, fy: 640, cx: 664.5, cy: 345, k1: -0.25, k2: 0.05 };
const PIVOT = [4.5, 3, 0];
const START = { rvec: [0, 0, 0], tvec: [-4.5, -3, 12] };
const TARGET = { rvec: [0.5, -0.4, 0.1], tvec: [-3, -2, 9] };
const CORNERS = corners(DEFAULT_BOARD);
const apart = (points, others) => rms(distances(points, others));
const hand = (kind, error = 0) => new Hand(kind, { error, seed: 3, pivot: PIVOT, focal: LENS.fx, start: START });

test("the board covers an outline drawn for another lens", () => {
  const drawn = { ...PINHOLE, cx: 639.5, cy: 359.5 };
  const target = targetOf(DEFAULT_BOARD, drawn, TARGET);
  assert.ok(apart(see(LENS, TARGET, CORNERS), target.corners) > 60, "the numbers alone lead far away");
  assert.ok(apart(see(LENS, matchPose(DEFAULT_BOARD, LENS, target), CORNERS), target.corners) < 12);
  assert.ok(apart(see(drawn, matchPose(DEFAULT_BOARD, drawn, target), CORNERS), target.corners) < 1e-6);
  assert.deepEqual(matchPose(DEFAULT_BOARD, LENS, TARGET), { rvec: TARGET.rvec, tvec: TARGET.tvec });
});

test("a hand arrives on time and trembles as specified", () => {
  for (const [kind, { travel, tremor, sway }] of Object.entries(HANDS)) {
    const one = hand(kind);
    one.follow(TARGET, 1000);
    const settled = 1000 + travel + 10;
    const away = Array.from({ length: 12 }, (_, i) =>
      apart(see(LENS, one.pose(settled + 110 * i), CORNERS), see(LENS, TARGET, CORNERS)),
    );
    const limit = 2.5 * (tremor + sway);
    assert.ok(Math.max(...away) <= limit + 1e-9, `${kind}: ${Math.max(...away)} px`);
    assert.ok(tremor === 0 || Math.max(...away) > tremor, kind);
    assert.equal(one.moves(settled), tremor > 0);
  }
});

test("a hand's way does not depend on painted frames", () => {
  const [seldom, often] = ["person", "person"].map((kind) => hand(kind, 1));
  for (let i = 0; i < 50; i++) often.blur();
  for (const each of [seldom, often]) each.follow(TARGET, 1000);
  assert.deepEqual(often.pose(3000), seldom.pose(3000));
  assert.ok(Array.from({ length: 100 }, () => often.blur()).some((px) => px > 0));
});
