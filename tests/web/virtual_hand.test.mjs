import assert from "node:assert/strict";
import { test } from "node:test";
import { DEFAULT_BOARD, corners } from "../../web/lib/board.js";
import { HANDS, Hand } from "../../web/lib/virtual/hand.js";
import { matchPose } from "../../web/lib/virtual/match.js";
import { transformPoint } from "../../web/lib/pose.js";
import { see } from "./scenes.mjs";

const LENS = { fx: 640, fy: 640, cx: 664.5, cy: 345, k1: -0.25, k2: 0.05, p1: 0, p2: 0, k3: 0 };
const PIVOT = [4.5, 3, 0];
const START = { rvec: [0, 0, 0], tvec: [-4.5, -3, 12] };
const TARGET = { rvec: [0.5, -0.4, 0.1], tvec: [-3, -2, 9] };
const CORNERS = corners(DEFAULT_BOARD);
const ids = CORNERS.map((_, id) => id);
const rms = (a, b) =>
  Math.sqrt(a.reduce((sum, [x, y], i) => sum + (x - b[i][0]) ** 2 + (y - b[i][1]) ** 2, 0) / a.length);
const hand = (kind, error = 0) => new Hand(kind, { error, seed: 3, pivot: PIVOT, focal: LENS.fx, start: START });

test("the board covers an outline drawn for another lens", () => {
  const drawn = { ...LENS, fx: 1000, fy: 1000, cx: 639.5, cy: 359.5, k1: 0, k2: 0 };
  const target = { ...TARGET, ids, corners: see(drawn, TARGET, CORNERS) };
  assert.ok(rms(see(LENS, TARGET, CORNERS), target.corners) > 60, "the numbers alone lead far away");
  assert.ok(rms(see(LENS, matchPose(DEFAULT_BOARD, LENS, target), CORNERS), target.corners) < 12);
  assert.ok(rms(see(drawn, matchPose(DEFAULT_BOARD, drawn, target), CORNERS), target.corners) < 1e-6);
  assert.deepEqual(matchPose(DEFAULT_BOARD, LENS, TARGET), { rvec: TARGET.rvec, tvec: TARGET.tvec });
});

test("a hand arrives on time and trembles as specified", () => {
  for (const [kind, { travel, tremor, sway, astray }] of Object.entries(HANDS)) {
    const one = hand(kind);
    one.follow(TARGET, 1000);
    const settled = 1000 + travel + astray + 10;
    one.pose(1000 + astray + 1);
    const away = Array.from({ length: 12 }, (_, i) =>
      rms(see(LENS, one.pose(settled + 110 * i), CORNERS), see(LENS, TARGET, CORNERS)),
    );
    const limit = 2.5 * (tremor + sway);
    assert.ok(Math.max(...away) <= limit + 1e-9, `${kind}: ${Math.max(...away)} px`);
    assert.ok(tremor === 0 || Math.max(...away) > tremor, kind);
    assert.equal(one.moves(settled), tremor > 0);
  }
});

test("a hand that goes astray is on the other side first", () => {
  const one = hand("wrong");
  one.follow(TARGET, 0);
  const side = (time) => transformPoint(one.pose(time), PIVOT)[0];
  const [goal] = transformPoint(TARGET, PIVOT);
  assert.ok(Math.sign(side(3_000)) === -Math.sign(goal));
  assert.ok(Math.abs(side(6_000) - goal) < 0.05);
});

test("a hand's way does not depend on painted frames", () => {
  const [seldom, often] = ["person", "person"].map((kind) => hand(kind, 1));
  for (let i = 0; i < 50; i++) often.blur();
  for (const each of [seldom, often]) each.follow(TARGET, 1000);
  assert.deepEqual(often.pose(3000), seldom.pose(3000));
  assert.ok(Array.from({ length: 100 }, () => often.blur()).some((px) => px > 0));
});
