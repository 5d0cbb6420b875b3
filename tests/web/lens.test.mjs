import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { COEFFICIENTS } from "../../web/sdk/projection.js";
import { Calibration, UnknownModelError, lensOf, projectionMatrix } from "../../web/sdk/calibdb.js";
import { widePinhole } from "../../web/sdk/rectification.js";
import { rectifiedMatrix, rectifyingMap } from "../../web/sdk/rectifier.js";

const { lenses: vectors } = JSON.parse(readFileSync(new URL("../data/vectors.json", import.meta.url), "utf8"));
const distance = (a, b) => Math.hypot(...a.map((value, axis) => value - b[axis]));

const intrinsicsOf = ({ model, k: [fx, fy, cx, cy, ...d] }) => ({
  camera_matrix: [
    [fx, 0, cx],
    [0, fy, cy],
    [0, 0, 1],
  ],
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

const WIDE = {
  img_size: [1280, 720],
  camera_matrix: [
    [1013.7, 0, 652.3],
    [0, 1009.1, 348.8],
    [0, 0, 1],
  ],
  distortion_model: "rectilinear",
  distortion_coefficients: [-0.1, 0.02, 0.001, -0.002, 0.003],
};
/** Position at which a matrix draws a point, from the viewport's top-left corner. */
function drawn(m, [x, y, z], [width, height]) {
  const [a, b, c] = [x, -y, -z];
  const at = (row) => m[row] * a + m[4 + row] * b + m[8 + row] * c + m[12 + row];
  return [((at(0) / at(3) + 1) / 2) * width, ((1 - at(1) / at(3)) / 2) * height, at(2) / at(3)];
}

test("depth runs from -1 at the near plane to 1 at the far one", () => {
  const depth = (frustum, z) => drawn(projectionMatrix(WIDE, frustum), [0, 0, z], [1, 1])[2];
  assert.ok(
    Math.abs(depth({ near: 0.2, far: 50 }, 0.2) + 1) < 1e-12 && Math.abs(depth({ near: 0.2, far: 50 }, 50) - 1) < 1e-12,
  );
  assert.ok(
    Math.abs(depth({ near: 0.2, far: Infinity }, 0.2) + 1) < 1e-12 && depth({ far: Infinity }, 1e9) > 0.999999999,
  );
});

const LENSES = vectors.map(intrinsicsOf);

test("OpenCV gets what each of its modules takes", () => {
  const cameraMatrix = [1013.7, 0, 652.3, 0, 1009.1, 348.8, 0, 0, 1];
  const of = (distortion_model, distortion_coefficients) =>
    new Calibration({ ...WIDE, distortion_model, distortion_coefficients }).toOpenCV();
  assert.deepEqual(new Calibration(WIDE).toOpenCV(), {
    imageSize: [1280, 720],
    cameraMatrix,
    distCoeffs: WIDE.distortion_coefficients,
    module: "",
  });
  assert.deepEqual(of("fisheye", [1, 2, 3, 4]), {
    imageSize: [1280, 720],
    cameraMatrix,
    distCoeffs: [1, 2, 3, 4],
    module: "fisheye",
  });
  assert.deepEqual(of("omnidirectional", [1.2, 1, 2, 3, 4]), {
    imageSize: [1280, 720],
    cameraMatrix,
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
  assert.deepEqual([...new Set(weak.map(({ distortion_model }) => distortion_model))].sort(), [
    "fisheye",
    "omnidirectional",
    "rational",
    "rectilinear",
  ]);
  for (const { camera_matrix, distortion_model, distortion_coefficients } of weak) {
    const calibration = new Calibration({
      camera_matrix,
      distortion_model,
      distortion_coefficients,
      img_size: [1280, 720],
    });
    const matrix = calibration.projectionMatrix();
    const [x, y] = magnification(lensOf(calibration));
    assert.ok(Math.abs((matrix[0] * 640) / x - 1) < 1e-9, `${distortion_model}: ${matrix[0] * 640} px instead of ${x}`);
    assert.ok(Math.abs((matrix[5] * 360) / y - 1) < 1e-9, `${distortion_model}: ${matrix[5] * 360} px instead of ${y}`);
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
const matrix = [
  [500, 0, 325],
  [0, 500, 178],
  [0, 0, 1],
];
const barrel = {
  img_size: SIZE,
  camera_matrix: matrix,
  distortion_model: "rectilinear",
  distortion_coefficients: [-0.25, 0.05, 0, 0, 0],
};
const fisheye = {
  img_size: SIZE,
  camera_matrix: [
    [180, 0, 320],
    [0, 180, 180],
    [0, 0, 1],
  ],
  distortion_model: "fisheye",
  distortion_coefficients: [0, 0, 0, 0],
};
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
  for (const corner of [
    [0, 0],
    [SIZE[0] - 1, 0],
    [0, SIZE[1] - 1],
    [SIZE[0] - 1, SIZE[1] - 1],
  ]) {
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
  const lenses = {
    rectilinear: [
      [900, 900],
      [-0.1, 0.01, 0, 0, 0],
    ],
    rational: [
      [900, 900],
      [-0.1, 0.01, 0, 0, 0, 0.01, 0, 0],
    ],
    fisheye: [
      [900, 900],
      [-0.01, 0, 0, 0],
    ],
    omnidirectional: [
      [1800, 1800],
      [1, 0, 0, 0, 0],
    ],
  };
  for (const [distortion_model, [[fx, fy], distortion_coefficients]] of Object.entries(lenses)) {
    const {
      img_size: [width, height],
      camera_matrix: [[f]],
    } = widePinhole({
      img_size: [1280, 720],
      camera_matrix: [
        [fx, 0, 639.5],
        [0, fy, 359.5],
        [0, 0, 1],
      ],
      distortion_model,
      distortion_coefficients,
    });
    assert.equal(f, 900, distortion_model);
    assert.ok(width < 1.35 * 1280 && height < 1.35 * 720, `${distortion_model}: ${width}x${height}`);
  }
});
