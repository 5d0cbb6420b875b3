import assert from "node:assert/strict";
import { test } from "node:test";
import { DEFAULT_BOARD, corners } from "../../web/lib/board.js";
import { drawnBoard } from "../../web/photos/wanted.js";
import { isInside } from "./scenes.mjs";
import { transformPoint } from "../../web/lib/pose.js";
import { projectionOf } from "../../web/lib/virtual/lens.js";

const POSE = { rvec: [0.3, -0.4, 0.05], tvec: [-5.5, -3.5, 9] };
/** A lens whose model folds the edge of the board back: a fit of few views may say that. */
const FOLDING = projectionOf({ fx: 900, fy: 900, cx: 640, cy: 360, k1: -0.5, k2: 0.1, p1: 0, p2: 0, k3: 0 });

for (const board of [
  DEFAULT_BOARD,
  { ...DEFAULT_BOARD, squares: [4, 5], inverted: true },
  { ...DEFAULT_BOARD, kind: "chessboard", squares: [9, 7] },
]) {
  test(`the squares and markers of a drawn board lie within its rim: ${JSON.stringify(board)}`, () => {
    const places = corners(board);
    const project = (place) => FOLDING.project(transformPoint(POSE, [...place, 0]));
    const pose = {
      ids: places.map((_, id) => id),
      corners: places.map(project),
      outline: [
        [0, 0],
        [1, 0],
        [1, 1],
        [0, 1],
      ],
    };
    const { rim, black } = drawnBoard(board, pose);
    const centres = black.map((polygon) =>
      [0, 1].map((k) => polygon.reduce((sum, point) => sum + point[k], 0) / polygon.length),
    );
    assert.ok(centres.every((centre) => isInside(centre, rim)));
    assert.ok(pose.corners.every((corner) => isInside(corner, rim)));
    assert.ok(black.length > (board.kind === "chessboard" ? 30 : 100));
    const some = pose.ids.filter((id) => id % 5 !== 0);
    const part = drawnBoard(board, { ...pose, ids: some, corners: some.map((id) => pose.corners[id]) });
    assert.equal(part.black.length, black.length);
  });
}
