import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { DEFAULT_BOARD } from "../../web/lib/board.js";
import { observedOutline } from "../../web/lib/board-outline.js";
import { nextPlanned, plannedPose, trustedCalibration } from "../../web/calibrate/plan.js";

const PLAN = JSON.parse(readFileSync(new URL("../../web/calibrate/plan.json", import.meta.url), "utf8"));
const camera = ([width, height], k1, k2 = 0, f = 0.8) => ({
  camera_matrix: [
    [f * Math.max(width, height), 0, (width - 1) / 2 + 12],
    [0, f * Math.max(width, height), (height - 1) / 2],
    [0, 0, 1],
  ],
  distortion_coefficients: [k1, k2, 0, 0, 0],
  distortion_model: "rectilinear",
});

/** Does a polygon turn one way all round? */
function isConvex(vertices) {
  const turns = vertices.map(([x, y], index) => {
    const [[a, b], [c, d]] = [vertices[(index + 1) % 4], vertices[(index + 2) % 4]];
    return (a - x) * (d - b) - (b - y) * (c - a);
  });
  return turns.every((turn) => turn > 0) || turns.every((turn) => turn < 0);
}

for (const size of [
  [1280, 720],
  [640, 360],
  [720, 1280],
  [640, 480],
]) {
  for (const [k1, k2] of [
    [0, 0],
    [-0.25, 0],
    [-0.3, 0],
    [-0.35, 0.05],
    [-0.4, 0],
    [-0.45, 0],
    [-0.25, -0.1],
    [-3, 2],
  ]) {
    test(`every target without the service is a whole board, ${size.join("x")}, k1 ${k1}, k2 ${k2}`, () => {
      let from = 0;
      for (let step = 0; step < PLAN.length; step++) {
        const { pose, next } = nextPlanned(PLAN, from, DEFAULT_BOARD, size, camera(size, k1, k2));
        assert.equal(pose.outline.length, 4);
        assert.ok(isConvex(pose.outline), JSON.stringify(pose.outline));
        assert.ok(pose.ids.length >= 24, `${pose.ids.length} corners`);
        assert.ok(observedOutline(DEFAULT_BOARD, { ids: pose.ids, points: pose.corners }));
        from = next;
      }
    });
  }
}

test("the plan's own camera can draw all of it", () => {
  for (const step of PLAN) assert.ok(plannedPose(step, DEFAULT_BOARD, [1280, 720], null));
  assert.equal(nextPlanned([], 0, DEFAULT_BOARD, [1280, 720], null), null);
});

test("an estimate of fewer than three views draws nothing", () => {
  const calibration = camera([1280, 720], -0.2);
  const views = (count, aside = 0) =>
    Array.from({ length: count }, (_, index) => ({ set_aside: index < aside ? {} : null }));
  assert.equal(trustedCalibration(null), null);
  assert.equal(trustedCalibration({ calibration, views: views(2) }), null);
  assert.equal(trustedCalibration({ calibration, views: views(3, 1) }), null);
  assert.equal(trustedCalibration({ calibration, views: views(3) }), calibration);
});

test("a target without the service is as large for every model of the same focal length at the axis", () => {
  const size = [1280, 720];
  const matrix = (f) => [
    [f, 0, 639.5],
    [0, f, 359.5],
    [0, 0, 1],
  ];
  const plain = {
    camera_matrix: matrix(1024),
    distortion_model: "rectilinear",
    distortion_coefficients: [0, 0, 0, 0, 0],
  };
  const generalised = {
    camera_matrix: matrix(2048),
    distortion_model: "omnidirectional",
    distortion_coefficients: [1, 0, 0, 0, 0],
  };
  for (const step of PLAN) {
    const poses = [plain, generalised].map((known) => plannedPose(step, DEFAULT_BOARD, size, known));
    const [expected, actual] = poses.map((pose) => pose.tvec[2]);
    assert.ok(Math.abs(actual / expected - 1) < 1e-12, `${actual} squares away instead of ${expected}`);
  }
});

test("a model that this page does not know is drawn as by the plan's own camera", () => {
  const unknown = { ...camera([1280, 720], 0), distortion_model: "double-sphere" };
  assert.deepEqual(
    nextPlanned(PLAN, 0, DEFAULT_BOARD, [1280, 720], unknown),
    nextPlanned(PLAN, 0, DEFAULT_BOARD, [1280, 720], null),
  );
});
