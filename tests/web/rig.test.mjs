import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { Calibration, Rig, lensOf, rectifyPair, rig } from "../../web/sdk/calibdb.js";
import { compose, invert, multiply, rigidMotion, rotate, rotationVectorOf, transform } from "../../web/sdk/motion.js";
import { rectify, rectifiedMotions } from "../../web/sdk/stereo.js";
import { Matrix4, Vector3 } from "three";
import { json } from "./globals.mjs";
import { rms } from "./scenes.mjs";

const read = (name) => JSON.parse(readFileSync(new URL(name, import.meta.url), "utf8"));
/** Pairs as the solver rectifies them; the first is OpenCV's own, fitted to real corners. */
const { pairs: PAIRS } = read("../data/vectors.json");
const [REAL] = PAIRS;
const rectifyReal = (options) => rectify(REAL.left, REAL.right, REAL.pose, options);
const ID = "1f0c7a3e5b2d49688c1e0f7d6a5b4c3d";
const STILL = { position: 0, rvec: [0, 0, 0], tvec: [0, 0, 0], std: [0, 0, 0, 0, 0, 0] };
const RESULT = {
  calibrations: [REAL.left, REAL.right],
  extrinsics: [STILL, { position: 1, ...REAL.pose, std: [0.001, 0.001, 0.0005, 0.01, 0.01, 0.02] }],
  unit: "squares",
  board_poses: [{ moment: "m1", rvec: [0.1, 0, 0], tvec: [-4, -3, 12] }],
};
const difference = (a, b) => Math.max(...a.flat().map((value, at) => Math.abs(value - b.flat()[at])));

// Requests of rigs, and the service's words: tests/service/rigs/test_rig_capture.py.
test("a rig has calibrations and poses", () => {
  const found = new Rig(RESULT);
  assert.ok(found.calibrations.every((each) => each instanceof Calibration));
  const { rvec, tvec, rotation, matrix, std } = found.pose(1);
  assert.ok(difference(rvec, REAL.pose.rvec) < 1e-15 && difference(tvec, REAL.pose.tvec) === 0);
  assert.deepEqual(std, RESULT.extrinsics[1].std);
  const point = [0.3, 0.2, 5];
  const there = new Vector3(...point).applyMatrix4(new Matrix4().fromArray(matrix));
  assert.ok(difference(there.toArray(), transform({ r: rotation.flat(), t: tvec }, point)) < 1e-12);
});

test("poses lead from any camera to any other, there and back", () => {
  const third = { position: 2, rvec: [0.3, -1.2, 0.4], tvec: [1, 2, -3], std: [1, 1, 1, 1, 1, 1] };
  const three = new Rig({
    ...RESULT,
    calibrations: [REAL.left, REAL.right, REAL.left],
    extrinsics: [...RESULT.extrinsics, third],
  });
  const [a, b] = [rigidMotion(three.pose(1)), rigidMotion(three.pose(2, 1))];
  const whole = compose(b, a);
  assert.ok(difference(rotationVectorOf(whole.r), third.rvec) < 1e-12 && difference(whole.t, third.tvec) < 1e-12);
  const point = [0.3, 0.2, 5];
  assert.ok(difference(transform(rigidMotion(three.pose(1, 2)), transform(b, point)), point) < 1e-12);
  assert.equal(three.pose(2, 1).std, null, "errors are known from camera 0");
  assert.throws(() => three.pose(3), /cameras 0 to 2, and no camera 3/);
  assert.ok(difference(multiply(a.r, invert(a).r), [1, 0, 0, 0, 1, 0, 0, 0, 1]) < 1e-15);
});

test("a rig in squares becomes one in metres", () => {
  const found = new Rig(RESULT);
  const metres = found.toMetres(0.03);
  assert.ok(metres instanceof Rig && metres.unit === "metres" && found.unit === "squares");
  assert.ok(
    difference(
      metres.pose(1).tvec,
      REAL.pose.tvec.map((value) => 0.03 * value),
    ) < 1e-15,
  );
  assert.deepEqual(metres.pose(1).std, [0.001, 0.001, 0.0005, 0.01 * 0.03, 0.01 * 0.03, 0.02 * 0.03]);
  assert.ok(difference(metres.board_poses[0].tvec, [-0.12, -0.09, 0.36]) < 1e-15);
  assert.equal(metres.toMetres(), metres);
  for (const size of [undefined, 0, -1, Number.NaN])
    assert.throws(() => found.toMetres(size), /how large one is, in metres/);
});

test("errors say what to change", async () => {
  const options = { token: "cdb_a_b", api: "https://calibdb.example/v1", fetch: async () => json(200, {}) };
  await assert.rejects(rig(ID, options), /is not calibDB/);
  for (const id of [undefined, "", "..", `https://calibdb.example/rig/?id=${ID}`])
    await assert.rejects(rig(id, options), /its id stands in the address/);
  for (const data of [undefined, {}, { ...RESULT, extrinsics: [] }, { ...RESULT, calibrations: [REAL.left] }]) {
    assert.throws(() => new Rig(data), /this is no rig/);
  }
});

test("pairs of all camera models are rectified as the solver does", () => {
  const models = new Set(PAIRS.flatMap(({ left, right }) => `${left.distortion_model} ${right.distortion_model}`));
  assert.equal(models.size, 16);
  assert.ok(PAIRS.some(({ isVertical }) => isVertical) && PAIRS.some(({ P2 }) => P2[0][3] > 0));
  for (const { left, right, pose, ...expected } of PAIRS) {
    const found = rectify(left, right, pose);
    for (const name of ["R1", "R2", "P1", "P2", "Q"]) {
      assert.ok(
        difference(found[name], expected[name]) < 1e-7,
        `${name} of ${left.distortion_model} and ${right.distortion_model}`,
      );
    }
    assert.equal(found.isVertical, expected.isVertical);
    assert.ok(Math.abs(found.baseline * found.Q[3][2] - 1) < 1e-12 && found.focal === found.P1[0][0]);
  }
});

test("scaled and zoomed pictures keep depths", () => {
  const whole = rectifyReal();
  const half = rectifyReal({ scale: 0.5, zoom: 2 });
  assert.deepEqual(half.img_size, [320, 240]);
  assert.ok(Math.abs(half.focal - whole.focal) < 1e-9 && Math.abs(half.baseline - whole.baseline) < 1e-12);
  const plain = rectifyReal({ scale: 0.5 });
  for (const axis of [0, 1]) assert.ok(Math.abs(plain.P1[axis][2] + 0.5 - (whole.P1[axis][2] + 0.5) / 2) < 1e-9);
});

test("real corners lie in one row, and squares have their size", (t) => {
  const sides = ["left", "right"].map((side) => read(`../data/corners/opencv_${side}.json`));
  const found = rectifyReal();
  const place = (camera, r, p, pixel) => {
    const [x, y, z] = rotate(r.flat(), lensOf(camera).unproject(pixel));
    return [0, 1].map((row) => (p[row][0] * x + p[row][1] * y + p[row][2] * z) / z);
  };
  const rows = [];
  const squares = [];
  for (const { file, img } of sides[0].views) {
    const other = sides[1].views.find((view) => view.file === file.replace("left", "right"));
    if (!other || file === "left09.jpg") continue; // its corners are numbered from another end
    const points = img.map((pixel, corner) => {
      const a = place(REAL.left, found.R1, found.P1, pixel);
      const b = place(REAL.right, found.R2, found.P2, other.img[corner]);
      rows.push(a[1] - b[1]);
      const depth = (found.focal * found.baseline) / (a[0] - b[0]);
      return [((a[0] - found.P1[0][2]) * depth) / found.focal, ((a[1] - found.P1[1][2]) * depth) / found.focal, depth];
    });
    // Neighbours of a row of nine are one square apart.
    for (let at = 1; at < 9; at++)
      squares.push(Math.hypot(...points[at].map((value, axis) => value - points[at - 1][axis])));
  }
  const side = squares.sort((a, b) => a - b)[squares.length >> 1];
  t.diagnostic(`${rms(rows).toFixed(3)} px between rows, a square is ${side.toFixed(4)} squares`);
  assert.ok(rows.length === 12 * 54 && rms(rows) < 0.35, `rms ${rms(rows)} px of ${rows.length}`);
  assert.ok(Math.abs(side - 1) < 0.01, `a square is ${side} squares`);
});

test("a pair that has no rectified pictures says why", async () => {
  const cameras = { left: REAL.left, right: REAL.right };
  for (const [rvec, tvec, message] of [
    [[0, 0, 0], [0, 0, 0], /in one place/],
    [[0, 2.9, 0], [-1, 0, 0], /directions too far apart/],
  ])
    assert.throws(() => rectify(REAL.left, REAL.right, { rvec, tvec }), { name: "RectificationError", message });
  for (const unknown of [undefined, {}, cameras])
    await assert.rejects(rectifyPair({}, {}, unknown), /a rig, or { left, right, pose }/);
  await assert.rejects(rectifyPair({}, {}, new Rig(RESULT), { positions: [0, 2] }), /no camera 2/);
  const odd = { width: 640, height: 640 };
  await assert.rejects(
    rectifyPair(odd, odd, { ...cameras, pose: REAL.pose }, { canvases: [{}, {}] }),
    /the left picture has 640 x 640 px, its calibration is for 640 x 480 px/,
  );
  await assert.rejects(
    rectifyPair({ width: 640, height: 480 }, odd, new Rig(RESULT), { packing: "beside", canvases: [{}, {}] }),
    /the left picture has 640 x 480 px, its calibration is for 1280 x 480 px/,
  );
});

/** Pixel at which a view draws a point of the world, from its picture's top-left corner. */
function drawn({ projectionMatrix, transform: { inverse } }, point, [width, height]) {
  const there = new Vector3(...point).applyMatrix4(new Matrix4().fromArray(inverse.matrix));
  const { x, y } = there.applyMatrix4(new Matrix4().fromArray(projectionMatrix));
  return [((x + 1) / 2) * width - 0.5, ((1 - y) / 2) * height - 0.5];
}
const positionOf = ({ transform: { position } }) => [position.x, position.y, position.z];

test("views of both eyes see the world as their cameras do", () => {
  const found = new Rig(RESULT);
  const [left, right] = found.views({ near: 0.1, far: 100 });
  assert.deepEqual([left.eye, right.eye, right.distortionModel], ["left", "right", "rectilinear"]);
  const point = [1.2, -0.7, 14]; // squares, camera 0, as OpenCV has it
  [
    [left, point],
    [right, transform(rigidMotion(found.pose(1)), point)],
  ].forEach(([view, [x, y, z]], index) => {
    const {
      camera_matrix: [[fx, , cx], [, fy, cy]],
      img_size,
    } = found.calibrations[index];
    const at = drawn(view, [point[0], -point[1], -point[2]], img_size);
    assert.ok(difference(at, [(fx * x) / z + cx, (fy * y) / z + cy]) < 1e-3, `${view.eye} ${at}`);
    assert.ok(difference([...view.cameraMatrix], [fx, 0, 0, 0, fy, 0, cx, cy, 1]) < 1e-3);
  });
  const centre = invert(rigidMotion(found.pose(1))).t;
  const { position, orientation } = right.transform;
  assert.ok(difference(positionOf(right), [centre[0], -centre[1], -centre[2]]) < 1e-12 && position.w === 1);
  assert.ok(Math.abs(Math.hypot(...Object.values(orientation)) - 1) < 1e-12);
});

test("the left eye is on the left, and both follow a pose", () => {
  const { r, t } = invert(rigidMotion(REAL.pose));
  const swapped = new Rig({
    ...RESULT,
    calibrations: [REAL.right, REAL.left],
    extrinsics: [STILL, { position: 1, rvec: rotationVectorOf(r), tvec: t, std: STILL.std }],
  });
  const [left] = swapped.views();
  assert.ok(Math.abs(left.cameraMatrix[0] - REAL.left.camera_matrix[0][0]) < 1e-3);
  // The world turned by a quarter about y, and 2 to the right
  const pose = new Matrix4().makeRotationY(Math.PI / 2).setPosition(2, 0, 0);
  const found = new Rig(RESULT);
  const [at, moved] = [found.views(), found.views({ pose: pose.elements })].map(([, right]) => positionOf(right));
  assert.ok(difference(moved, new Vector3(...at).applyMatrix4(pose).toArray()) < 1e-12);
});

test("rectified cameras differ by the baseline alone", () => {
  for (const { left, right, pose } of PAIRS) {
    const found = rectify(left, right, pose);
    const [a, b] = rectifiedMotions(found, pose);
    const { r, t } = compose(b, invert(a));
    assert.ok(difference(r, [1, 0, 0, 0, 1, 0, 0, 0, 1]) < 1e-12);
    assert.ok(difference(t, found.isVertical ? [0, -found.baseline, 0] : [-found.baseline, 0, 0]) < 1e-9);
  }
});
