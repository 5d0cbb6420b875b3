import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { COEFFICIENTS, lensOf } from "../../web/sdk/projection.js";

const vectors = JSON.parse(readFileSync(new URL("../data/lens_vectors.json", import.meta.url), "utf8"));
const distance = (a, b) => Math.hypot(...a.map((value, axis) => value - b[axis]));

/** @param {{model: string, k: number[]}} record */
const intrinsicsOf = ({ model, k: [fx, fy, cx, cy, ...d] }) => ({
  camera_matrix: [
    [fx, 0, cx],
    [0, fy, cy],
    [0, 0, 1],
  ],
  distortion_model: model,
  distortion_coefficients: d,
});

test("rays and pixels are those of the solver to 1e-9 px, and null where it has none", () => {
  let count = 0;
  for (const { rays, pixels, seen, missed, ...record } of vectors) {
    const lens = lensOf(intrinsicsOf(record));
    const what = `${record.model} ${record.k}`;
    rays.forEach((ray, index) => {
      const pixel = lens.project(ray);
      assert.equal(pixel === null, pixels[index] === null, `${what} at ${ray}`);
      if (pixel) assert.ok(distance(pixel, pixels[index]) < 1e-9, `${what} at ${ray}`);
      count += 1;
    });
    for (const pixel of seen) {
      const ray = lens.unproject(pixel);
      assert.ok(ray && distance(lens.project(ray), pixel) < 1e-9, `${what} at ${pixel}`);
    }
    for (const pixel of missed) assert.equal(lens.unproject(pixel), null, `${what} at ${pixel}`);
  }
  assert.ok(count > 2000, `${count} rays`);
});

test("every known model has names for its coefficients", () => {
  for (const { model, k } of vectors) assert.equal(COEFFICIENTS[model].length, k.length - 4);
});
