import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { Calibration, UnknownModelError, lensOf, projectionMatrix } from "../../web/sdk/calibdb.js";

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

test("depth runs from -1 at the near plane to 1 at the far one, also where that is infinitely far", () => {
  const depth = (frustum, z) => drawn(projectionMatrix(WIDE, frustum), [0, 0, z], [1, 1])[2];
  assert.ok(
    Math.abs(depth({ near: 0.2, far: 50 }, 0.2) + 1) < 1e-12 && Math.abs(depth({ near: 0.2, far: 50 }, 50) - 1) < 1e-12,
  );
  assert.ok(
    Math.abs(depth({ near: 0.2, far: Infinity }, 0.2) + 1) < 1e-12 && depth({ far: Infinity }, 1e9) > 0.999999999,
  );
});

const LENSES = JSON.parse(readFileSync(new URL("../data/lens_vectors.json", import.meta.url), "utf8")).map(
  ({ k: [fx, fy, cx, cy, ...distortion_coefficients], model: distortion_model, ...rest }) => ({
    camera_matrix: [
      [fx, 0, cx],
      [0, fy, cy],
      [0, 0, 1],
    ],
    distortion_coefficients,
    distortion_model,
    ...rest,
  }),
);

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

test("a scene over the picture is magnified as by the lens at its axis, for every model", () => {
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

test("a calibration of a model that this SDK does not know is data, and says so where its lens is asked for", () => {
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
