import assert from "node:assert/strict";
import { test } from "node:test";
import { misalignment } from "../../web/ar/misalignment.js";
import { model } from "../../web/ar/model.js";
import { rigidTransform, poseOf } from "../../web/lib/board-pose.js";
import { stopAt } from "../../web/ar/tour.js";
import { DEFAULT_BOARD, corners } from "../../web/lib/board.js";
import { lensOf } from "../../web/sdk/projection.js";
import { rotationMatrix } from "../../web/lib/pose.js";
import { calibrationOf, distances, rectangle } from "./scenes.mjs";

const SIZE = [1280, 720];
const calibration = calibrationOf([1000, 1010], [650, 352]);
const LENSES = {
  rectilinear: [
    [1000, 1010],
    [-0.3, 0.04, 0.001, -0.0008, 0],
  ],
  fisheye: [
    [480, 485],
    [-0.03, 0.01, -0.004, 0.001],
  ],
  rational: [
    [1000, 1010],
    [1.2, 0.3, 0.0005, -0.0004, 0.02, 1.5, 0.6, 0.06],
  ],
  omnidirectional: [
    [900, 909],
    [1.2, -0.1, 0.02, 0.0006, -0.0003],
  ],
};
const lensNamed = (distortion_model) => {
  const [focal, distortion_coefficients] = LENSES[distortion_model];
  return lensOf(calibrationOf(focal, [650, 352], { distortion_model, distortion_coefficients }));
};
const POINTS = corners(DEFAULT_BOARD);
const inside = ([u, v]) => u > 5 && v > 5 && u < SIZE[0] - 6 && v < SIZE[1] - 6;

/** Points of the board that a lens sees: in the picture, and on the board. */
function view(lens, pose) {
  const place = rigidTransform(pose);
  const pixels = POINTS.map(([x, y]) => lens.project(place([x, y, 0])));
  const seen = POINTS.map((_, index) => index).filter((index) => pixels[index] && inside(pixels[index]));
  return { points: seen.map((index) => POINTS[index]), pixels: seen.map((index) => pixels[index]) };
}

test("the board's pose is found through every model", () => {
  for (const model of Object.keys(LENSES)) {
    const lens = lensNamed(model);
    for (let stop = 0; stop < 4; stop++) {
      const pose = stopAt(DEFAULT_BOARD, calibration, stop);
      assert.ok(rotationMatrix(pose.rvec)[8] > 0.5, "the board faces the camera");
      const { points, pixels } = view(lens, pose);
      assert.ok(points.length >= 16, `${model}, stop ${stop}: ${points.length} corners`);
      const found = rigidTransform(poseOf(lens, points, pixels));
      const truth = rigidTransform(pose);
      const places = [
        [0, 0, 0],
        [9, 0, 0],
        [9, 6, -2],
      ];
      assert.ok(Math.max(...distances(places.map(found), places.map(truth))) < 1e-6, `${model}, stop ${stop}`);
    }
  }
});

test("too few corners, or corners on one line, tell no pose", () => {
  const lens = lensNamed("rectilinear");
  const { points, pixels } = view(lens, stopAt(DEFAULT_BOARD, calibration, 0));
  assert.equal(poseOf(lens, points.slice(0, 5), pixels.slice(0, 5)), null);
  const isInRow = (_, index) => points[index][1] === 2;
  const row = points.filter(isInRow);
  assert.ok(row.length >= 6);
  assert.equal(poseOf(lens, row, pixels.filter(isInRow)), null);
});

test("misalignment is rms, and that of the outermost corner", () => {
  const pose = { rvec: [0, 0, 0], tvec: [0, 0, 1] };
  const mode = { seen: (pixel) => (pixel[0] < 0 ? null : pixel), drawn: ([x, y]) => [x, y] };
  const points = [
    [10, 10],
    [600, 300],
    [5, 5],
  ];
  assert.deepEqual(
    misalignment(
      mode,
      pose,
      points,
      [
        [13, 14],
        [600, 300],
        [-1, -1],
      ],
      SIZE,
    ),
    { rms: Math.sqrt(25 / 2), outermost: 5 },
  );
  assert.equal(misalignment(mode, pose, [[1, 1]], [[-1, -1]], SIZE), null);
});

test("the model stands on the board, towards the viewer, with crosses at the outermost corners", () => {
  const numbers = model(DEFAULT_BOARD);
  const vertices = Array.from({ length: numbers.length / 6 }, (_, index) => [
    ...numbers.subarray(6 * index, 6 * index + 6),
  ]);
  assert.ok(vertices.every(([x, y, z]) => x >= -0.1 && x <= 9.1 && y >= -0.1 && y <= 6.1 && z <= 0));
  const blue = vertices.filter(([, , , red, , b]) => red === 0 && b === 1);
  for (const [x, y] of rectangle(1, 1, 7, 4))
    assert.equal(blue.filter(([u, v]) => Math.hypot(u - x, v - y) < 0.31).length, 12);
});
