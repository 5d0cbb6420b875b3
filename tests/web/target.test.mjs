import assert from "node:assert/strict";
import { test } from "node:test";
import { DEFAULT_BOARD, outline } from "../../web/lib/board.js";
import { advice, difference, jaccard } from "../../web/lib/capture/target.js";
import { projectionOf } from "../../web/lib/virtual/lens.js";
import { perturbPose, seededRandom, transformPoint } from "../../web/lib/pose.js";

const PROJECTION = projectionOf({ fx: 1000, fy: 1000, cx: 640, cy: 360, k1: -0.2, k2: 0, p1: 0, p2: 0, k3: 0 });
const CENTRE = [4.5, 3, 0];
const see = (pose) => outline(DEFAULT_BOARD).map(([x, y]) => PROJECTION.project(transformPoint(pose, [x, y, 0])));
/** The board turned so about its centre, which is there in the camera's frame. */
function held(rvec, centre) {
  const turned = transformPoint({ rvec, tvec: [0, 0, 0] }, CENTRE);
  return { rvec, tvec: centre.map((value, axis) => value - turned[axis]) };
}
const TILTED = held([0.5, 0.5, 0], [0.5, 0.5, 11]);

test("a hand that follows a target lies as it does; a board facing the camera in its place does not", () => {
  const random = seededRandom(3);
  for (let i = 0; i < 200; i++) {
    assert.ok(difference(see(perturbPose(TILTED, 1, random, CENTRE)), see(TILTED)) < 0.08);
  }
  let inPlace = 0;
  for (let z = 9; z < 16; z += 0.25) {
    const facing = see(held([0, 0, 0], [0.5, 0.5, z]));
    if (jaccard(facing, see(TILTED), [1280, 720]) <= 0.6) continue;
    inPlace += 1;
    assert.ok(difference(facing, see(TILTED)) > 0.08, `at ${z}`);
  }
  assert.ok(inPlace > 5, "overlap alone takes it for there");
});

test("the other way up is as good", () => {
  const [a, b, c, d] = see(TILTED);
  assert.ok(difference([c, d, a, b], see(TILTED)) < 1e-12);
  assert.equal(advice([c, d, a, b], see(TILTED)), "");
});

test("the largest difference first, in what a hand may miss by; nothing where nothing is left", () => {
  const target = see(held([0, 0.5, 0], [0, 0, 11]));
  const said = (rvec, centre) => advice(see(held(rvec, centre)), target);
  assert.equal(said([0, 0.5, 0], [3, 2.5, 11]), "up_left");
  assert.equal(said([0, 0.4, 0], [-4, 0, 11]), "right");
  assert.equal(said([0, 0.5, 0], [0, 0, 17]), "closer");
  assert.equal(said([0, 0.5, 0], [0, 0, 7]), "farther");
  assert.equal(said([0, 0.45, -0.8], [0, 0, 11]), "turn_clockwise");
  assert.equal(said([0, 0, 0], [0, 0, 11]), "tilt_right");
  assert.equal(said([0, 0.5, 0], [0, 0, 11]), "");
});

test("the edge named is the one that is nearer in the target", () => {
  const facing = see(held([0, 0, 0], [0, 0, 11]));
  for (const [rvec, name] of [
    [[0, 0.5, 0], "right"],
    [[0, -0.5, 0], "left"],
    [[0.5, 0, 0], "top"],
    [[-0.5, 0, 0], "bottom"],
  ]) {
    const target = held(rvec, [0, 0, 11]);
    const side = { right: [9, 3], left: [0, 3], top: [4.5, 0], bottom: [4.5, 6] }[name];
    assert.ok(transformPoint(target, [...side, 0])[2] < 11, `${name} is nearer`);
    assert.equal(advice(facing, see(target)), `tilt_${name}`);
  }
});
