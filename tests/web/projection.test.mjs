import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { COEFFICIENTS, lensOf } from "../../web/sdk/projection.js";

const vectors = JSON.parse(readFileSync(new URL("./vectors.json", import.meta.url), "utf8"));
const distance = (a, b) => Math.hypot(...a.map((value, axis) => value - b[axis]));

test("rays and pixels are those of the solver, to a millionth of a pixel", () => {
  let seen = 0;
  for (const { pixels, rays, ...intrinsics } of vectors) {
    const lens = lensOf(intrinsics);
    const focal = intrinsics.camera_matrix[0][0];
    pixels.forEach((pixel, index) => {
      const ray = lens.unproject(pixel);
      const what = `${intrinsics.distortion_model} ${intrinsics.distortion_coefficients} at ${pixel}`;
      if (rays[index] === null) return assert.equal(ray, null, what);
      seen += 1;
      assert.ok(ray, what);
      assert.ok(distance(ray, rays[index]) * focal < 1e-6, what);
      assert.ok(distance(lens.project(rays[index]), pixel) < 1e-6, what);
    });
  }
  assert.ok(seen > 250, `${seen} rays`);
});

test("what the lens cannot see is not projected", () => {
  const pinhole = { camera_matrix: [[1000, 0, 640], [0, 1000, 360], [0, 0, 1]], distortion_model: "rectilinear", distortion_coefficients: [-0.25, 0, 0, 0, 0] };
  const lens = lensOf(pinhole);
  assert.equal(lens.project([0, 0, -1]), null);
  // 1 - 3 · 0.25 r² = 0 at r = 1.1547: there the picture turns back.
  assert.ok(Math.abs(Math.tan(lens.limit) - Math.sqrt(4 / 3)) < 1e-9);
  assert.equal(lens.project([1.2, 0, 1]), null);
  assert.equal(lens.unproject([640 + 1000, 360]), null);
  assert.deepEqual(lens.project([0, 0, 2]), [640, 360]);
});

test("a fisheye sees behind itself", () => {
  const fisheye = { camera_matrix: [[260, 0, 640], [0, 260, 360], [0, 0, 1]], distortion_model: "fisheye", distortion_coefficients: [0, 0, 0, 0] };
  const lens = lensOf(fisheye);
  const [u, v] = lens.project([1, 0, -0.2]);
  assert.ok(Math.abs(u - 640 - 260 * Math.atan2(1, -0.2)) < 1e-9 && v === 360);
  assert.ok(lens.unproject([u, v])[2] < 0);
});

test("an unknown model is refused, and every known one has names for its coefficients", () => {
  assert.throws(() => lensOf({ camera_matrix: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], distortion_model: "cubic", distortion_coefficients: [] }), /cubic/);
  for (const { distortion_model, distortion_coefficients } of vectors) {
    assert.equal(COEFFICIENTS[distortion_model].length, distortion_coefficients.length);
  }
});
