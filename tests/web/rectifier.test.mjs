import assert from "node:assert/strict";
import { test } from "node:test";
import { lensOf } from "../../web/sdk/projection.js";
import { widePinhole } from "../../web/sdk/rectification.js";
import { rectifiedMatrix, rectifyingMap } from "../../web/sdk/rectifier.js";

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

test("balance 0 shows no black edge, balance 1 loses nothing of the picture", () => {
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

test("a lens that sees more than a plane can show is cut, not squeezed to nothing", () => {
  const [[f]] = rectifiedMatrix(fisheye, 1);
  assert.ok(f > 180 / 5 / 2 && Number.isFinite(f), `${f}`);
  assert.ok(filled(fisheye, 0) > 0.99);
});

test("a scene to be distorted is rendered as sharply as the lens is at its axis, for every model", () => {
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
