import assert from "node:assert/strict";
import { test } from "node:test";
import { interpolatePose, perturbPose, seededRandom, transformPoint } from "../../web/lib/pose.js";
import { labelOf, setupFrom } from "../../web/lib/virtual/setup.js";

test("half way and then all of it is the whole way", () => {
  const [from, to] = [
    { rvec: [0.1, 0.2, -0.1], tvec: [1, 2, 9] },
    { rvec: [-0.5, 0.6, 0.4], tvec: [0, 1, 5] },
  ];
  const there = interpolatePose(interpolatePose(from, to, 0.5), to, 1);
  there.rvec.forEach((value, index) => assert.ok(Math.abs(value - to.rvec[index]) < 1e-12));
});

test("a hand misses by about 3° and 3 %, reproducibly", () => {
  const target = { rvec: [0.5, -0.3, 0.1], tvec: [-4, -3, 10] };
  const random = seededRandom(7);
  const pivot = [4.5, 3, 0];
  const centre = transformPoint(target, pivot);
  const shifts = [];
  for (let i = 0; i < 400; i++) {
    const moved = transformPoint(perturbPose(target, 1, random, pivot), pivot);
    shifts.push(Math.hypot(...moved.map((value, k) => value - centre[k])) / Math.hypot(...centre));
  }
  const rms = Math.sqrt(shifts.reduce((sum, shift) => sum + shift ** 2, 0) / shifts.length);
  assert.ok(rms > 0.025 && rms < 0.035, `rms ${rms}`);
  assert.deepEqual(perturbPose(target, 1, seededRandom(3), pivot), perturbPose(target, 1, seededRandom(3), pivot));
});

test("an address sets the truth, and another truth is another camera", () => {
  const a = setupFrom(new URLSearchParams("virtual=1&fx=1000&cx=664.5&k1=-0.25&k2=0&error=0.5"));
  assert.deepEqual(
    [a.lens.fx, a.lens.fy, a.lens.cx, a.lens.k1, a.lens.k2, a.error],
    [1000, 1000, 664.5, -0.25, 0, 0.5],
  );
  assert.deepEqual(a.size, [1280, 720]);
  const b = setupFrom(new URLSearchParams("virtual=1&fx=1000&cx=664.5&k1=-0.26&k2=0&error=0.5"));
  assert.notEqual(labelOf(a), labelOf(b));
  assert.equal(labelOf(a), labelOf(setupFrom(new URLSearchParams("fx=1000&cx=664.5&k1=-0.25&k2=0&seed=9"))));
});

test("an address sets the frame rate within limits", () => {
  const rate = (address) => setupFrom(new URLSearchParams(address)).rate;
  assert.deepEqual(["", "rate=10", "rate=0", "rate=1e9", "rate=x"].map(rate), [30, 10, 2, 60, 30]);
});
