import assert from "node:assert/strict";
import { test } from "node:test";
import { DEFAULT_BOARD, corners, outline } from "../../web/lib/board.js";
import { foreshortening, observedOutline } from "../../web/lib/board-outline.js";
import { apply, homography } from "../../web/lib/homography.js";
import { see } from "./scenes.mjs";

const PINHOLE = { fx: 1000, fy: 1000, cx: 640, cy: 360, k1: 0, k2: 0, p1: 0, p2: 0, k3: 0 };
const BARREL = { ...PINHOLE, k1: -0.25 };
const POSE = { rvec: [0.5, -0.6, 0.2], tvec: [-4, -3, 11] };
test("a plane seen by a pinhole is a homography, to 1e-8 px", () => {
  const board = corners(DEFAULT_BOARD);
  const h = homography(board, see(PINHOLE, POSE, board));
  const corner = apply(h, [0, 0]);
  const [truth] = see(PINHOLE, POSE, [[0, 0]]);
  assert.ok(Math.hypot(corner[0] - truth[0], corner[1] - truth[1]) < 1e-8);
});

test("points on a line, or fewer than four, determine none", () => {
  assert.equal(
    homography(
      [
        [0, 0],
        [1, 0],
        [0, 1],
      ],
      [
        [0, 0],
        [1, 0],
        [0, 1],
      ],
    ),
    null,
  );
  const line = [
    [0, 0],
    [1, 1],
    [2, 2],
    [3, 3],
    [4, 4],
  ];
  assert.equal(homography(line, line), null);
});

test("the outline is found from a quarter of the corners to 2 % of the width", () => {
  const ids = [9, 10, 11, 17, 18, 19, 25, 26, 27, 28];
  const all = see(BARREL, POSE, corners(DEFAULT_BOARD));
  const seen = observedOutline(DEFAULT_BOARD, { ids, points: ids.map((id) => all[id]) });
  const truth = see(BARREL, POSE, outline(DEFAULT_BOARD));
  seen.forEach(([x, y], index) => {
    const error = Math.hypot(x - truth[index][0], y - truth[index][1]);
    assert.ok(error < 0.02 * 1280, `vertex ${index} is ${error.toFixed(1)} px off`);
  });
  assert.equal(
    observedOutline(DEFAULT_BOARD, {
      ids: [0, 1],
      points: [
        [0, 0],
        [9, 0],
      ],
    }),
    null,
  );
});

test("foreshortening tells a facing board from a tilted one", () => {
  const edge = outline(DEFAULT_BOARD);
  assert.ok(foreshortening(see(PINHOLE, { rvec: [0, 0, 0.3], tvec: [-4, -3, 12] }, edge)) < 1e-9);
  assert.ok(foreshortening(see(PINHOLE, { rvec: [0, 0.5, 0], tvec: [-4, -3, 12] }, edge)) > 0.2);
});
