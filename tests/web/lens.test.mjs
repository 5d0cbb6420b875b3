import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { COEFFICIENTS } from "../../web/sdk/projection.js";
import { Calibration, UnknownModelError, lensOf, projectionMatrix } from "../../web/sdk/calibdb.js";
import { widePinhole } from "../../web/sdk/rectification.js";
import { rectifiedMatrix, rectifyingMap } from "../../web/sdk/rectifier.js";

import { calibrationOf, cameraMatrix, rectangle } from "./scenes.mjs";

const { lenses: vectors } = JSON.parse(readFileSync(new URL("../data/vectors.json", import.meta.url), "utf8"));
const distance = (a, b) => Math.hypot(...a.map((value, axis) => value - b[axis]));

const intrinsicsOf = ({ model, k: [fx, fy, cx, cy, ...d] }) => ({
  camera_matrix: cameraMatrix([fx, fy], [cx, cy]),
  distortion_model: model,
  distortion_coefficients: d,
});

test("rays and pixels are the solver's to 1e-9 px", () => {
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

const WIDE = calibrationOf([1013.7, 1009.1], [652.3, 348.8], {
  distortion_coefficients: [-0.1, 0.02, 0.001, -0.002, 0.003],
});

test("depth runs from -1 at the near plane to 1 at the far one", () => {
  const depth = (far, z) => {
    const m = projectionMatrix(WIDE, { near: 0.2, far });
    return (m[14] - m[10] * z) / (m[15] - m[11] * z);
  };
  assert.ok(Math.abs(depth(50, 0.2) + 1) < 1e-12 && Math.abs(depth(50, 50) - 1) < 1e-12);
  assert.ok(Math.abs(depth(Infinity, 0.2) + 1) < 1e-12 && depth(Infinity, 1e9) > 0.999999999);
});

const LENSES = vectors.map(intrinsicsOf);

test("OpenCV gets what each of its modules takes", () => {
  const pinhole = { imageSize: [1280, 720], cameraMatrix: [1013.7, 0, 652.3, 0, 1009.1, 348.8, 0, 0, 1] };
  const of = (distortion_model, distortion_coefficients) =>
    new Calibration({ ...WIDE, distortion_model, distortion_coefficients }).toOpenCV();
  assert.deepEqual(new Calibration(WIDE).toOpenCV(), {
    ...pinhole,
    distCoeffs: WIDE.distortion_coefficients,
    module: "",
  });
  assert.deepEqual(of("fisheye", [1, 2, 3, 4]), {
    ...pinhole,
    distCoeffs: [1, 2, 3, 4],
    module: "fisheye",
  });
  assert.deepEqual(of("omnidirectional", [1.2, 1, 2, 3, 4]), {
    ...pinhole,
    distCoeffs: [1, 2, 3, 4],
    xi: 1.2,
    module: "omnidir",
  });
});

/** Derivative of the projection along x and y at the optical axis, px per radian, by central differences. */
function magnification({ project }) {
  const step = 1e-5;
  return [0, 1].map((axis) => {
    const [ahead, behind] = [step, -step].map((value) => project(axis === 0 ? [value, 0, 1] : [0, value, 1])[axis]);
    return (ahead - behind) / (2 * step);
  });
}

test("a scene is magnified as by the lens at its axis", () => {
  const weak = LENSES.filter(({ distortion_model, distortion_coefficients: d }) =>
    d.slice(distortion_model === "omnidirectional" ? 1 : 0).every((c) => Math.abs(c) < 0.1),
  );
  assert.equal(new Set(weak.map(({ distortion_model }) => distortion_model)).size, 4);
  for (const lens of weak) {
    const matrix = new Calibration({ ...lens, img_size: [1280, 720] }).projectionMatrix();
    const [x, y] = magnification(lensOf(lens));
    assert.ok(Math.abs((matrix[0] * 640) / x - 1) < 1e-9, `${lens.distortion_model}: ${matrix[0] * 640} px, not ${x}`);
    assert.ok(Math.abs((matrix[5] * 360) / y - 1) < 1e-9, `${lens.distortion_model}: ${matrix[5] * 360} px, not ${y}`);
  }
});

test("a calibration of an unknown model is data without a lens", () => {
  for (const distortion_model of ["double-sphere", "toString"]) {
    const data = { ...WIDE, distortion_model };
    const calibration = new Calibration(data);
    assert.deepEqual({ ...calibration }, data);
    assert.equal(calibration.toOpenCV().cameraMatrix[0], 1013.7);
    for (const ask of [() => calibration.project([0, 0, 1]), () => calibration.unproject([0, 0]), () => lensOf(data)]) {
      assert.throws(
        ask,
        (error) =>
          error instanceof UnknownModelError &&
          error.model === distortion_model &&
          error.message.includes(`"${distortion_model}"`),
      );
    }
  }
});

const SIZE = [640, 360];
const barrel = calibrationOf([500], [325, 178], {
  img_size: SIZE,
  distortion_coefficients: [-0.25, 0.05, 0, 0, 0],
});
const fisheye = calibrationOf([180], [320, 180], {
  img_size: SIZE,
  distortion_model: "fisheye",
  distortion_coefficients: [0, 0, 0, 0],
});
const inside = ([u, v]) => u >= -0.5 && v >= -0.5 && u <= SIZE[0] - 0.5 && v <= SIZE[1] - 0.5;
/** Part of the straightened picture that has something to show. */
function filled(calibration, balance) {
  const map = rectifyingMap(calibration, rectifiedMatrix(calibration, balance));
  let count = 0;
  for (let at = 0; at < map.length; at += 2) if (inside([map[at], map[at + 1]])) count += 1;
  return count / (map.length / 2);
}

test("balance 0 has no black edge, balance 1 the whole picture", () => {
  assert.ok(filled(barrel, 0) > 0.999, `${filled(barrel, 0)}`);
  assert.ok(filled(barrel, 1) < 0.97);
  const [[f, , cx], [, , cy]] = rectifiedMatrix(barrel, 1);
  const lens = lensOf(barrel);
  for (const corner of rectangle(0, 0, SIZE[0] - 1, SIZE[1] - 1)) {
    const [x, y, z] = lens.unproject(corner);
    const at = [(f * x) / z + cx, (f * y) / z + cy];
    assert.ok(at[0] > -1.5 && at[1] > -1.5 && at[0] < SIZE[0] + 0.5 && at[1] < SIZE[1] + 0.5, `${corner} at ${at}`);
  }
});

test("a lens wider than a plane is cut, not squeezed", () => {
  const [[f]] = rectifiedMatrix(fisheye, 1);
  assert.ok(f > 180 / 5 / 2 && Number.isFinite(f), `${f}`);
  assert.ok(filled(fisheye, 0) > 0.99);
});

test("a scene to distort is as sharp as the lens at its axis", () => {
  for (const [distortion_model, focal, distortion_coefficients] of [
    ["rectilinear", 900, [-0.1, 0.01, 0, 0, 0]],
    ["rational", 900, [-0.1, 0.01, 0, 0, 0, 0.01, 0, 0]],
    ["fisheye", 900, [-0.01, 0, 0, 0]],
    ["omnidirectional", 1800, [1, 0, 0, 0, 0]],
  ]) {
    const {
      img_size: [width, height],
      camera_matrix: [[f]],
    } = widePinhole(calibrationOf([focal], [639.5, 359.5], { distortion_model, distortion_coefficients }));
    assert.equal(f, 900, distortion_model);
    assert.ok(width < 1.35 * 1280 && height < 1.35 * 720, `${distortion_model}: ${width}x${height}`);
  }
});
