import assert from "node:assert/strict";
import { test } from "node:test";
import { jaccard } from "../../web/lib/capture/target.js";

const SIZE = [1280, 720];
const box = (x, y, w, h) => [
  [x, y],
  [x + w, y],
  [x + w, y + h],
  [x, y + h],
];

test("equal areas overlap wholly, separate ones not at all", () => {
  assert.equal(jaccard(box(100, 100, 400, 300), box(100, 100, 400, 300), SIZE), 1);
  assert.equal(jaccard(box(100, 100, 200, 200), box(700, 100, 200, 200), SIZE), 0);
  assert.equal(jaccard([], [], SIZE), 0);
});

test("a shift gives the ratio that geometry gives, to 0.01", () => {
  const shifted = jaccard(box(101, 99, 400, 300), box(202, 174, 400, 300), SIZE);
  const expected = (299 * 225) / (2 * 400 * 300 - 299 * 225);
  assert.ok(Math.abs(shifted - expected) < 0.01, `${shifted}, not ${expected}`);
});

test("what lies outside the image does not count", () => {
  assert.equal(jaccard(box(-900, -500, 1540, 860), box(0, 0, 640, 360), SIZE), 1);
});

test("a rotated square against its frame", () => {
  const diamond = [
    [640, 160],
    [840, 360],
    [640, 560],
    [440, 360],
  ];
  assert.ok(Math.abs(jaccard(diamond, box(440, 160, 400, 400), SIZE) - 0.5) < 0.01);
});

test("the winding of a polygon does not matter", () => {
  const a = box(300, 200, 300, 200);
  assert.equal(jaccard(a, [...a].reverse(), SIZE), 1);
});
