import assert from "node:assert/strict";
import { test } from "node:test";
import { PerspectiveCamera, Raycaster, Vector2, Vector3, WebGPUCoordinateSystem } from "three";
import { FreeCamera } from "@babylonjs/core/Cameras/freeCamera.js";
import { NullEngine } from "@babylonjs/core/Engines/nullEngine.js";
import { Matrix, Vector3 as BabylonVector } from "@babylonjs/core/Maths/math.vector.js";
import { Scene } from "@babylonjs/core/scene.js";
import { applyCalibration as applyToBabylon } from "../../web/sdk/adapters/babylon.js";
import { registerCalibrated } from "../../web/sdk/adapters/aframe.js";
import { applyCalibration as applyToThree } from "../../web/sdk/adapters/three.js";
import { calibrationOf } from "./scenes.mjs";

/** Landscape, portrait, pixels that are not square, and principal points far off the centre. */
const CAMERAS = [
  calibrationOf([1013.7, 1009.1], [652.3, 348.8]),
  calibrationOf([990, 991], [301.25, 702.5], { img_size: [720, 1280] }),
  calibrationOf([700, 350], [40, 455], { img_size: [640, 480] }),
];
const VIEWPORTS = [
  [1280, 720],
  [390, 844],
  [2560, 720],
  [1000, 1000],
  [320, 240],
];
const FITS = ["cover", "contain", "fill", "none", "scale-down"];
const POINTS = [
  [0.1, -0.2, 1.5],
  [-1.3, 0.8, 3],
  [0, 0, 0.5],
  [2, 1, 7.7],
  [-0.3, -0.4, 90],
];
const BOUND = 1e-9; // px

/** Layout of a picture by CSS: its top-left corner, and its size. */
function laidOut([w, h], [vw, vh], fit) {
  const whole = Math.min(vw / w, vh / h);
  const scale = { cover: Math.max(vw / w, vh / h), contain: whole, none: 1, "scale-down": Math.min(1, whole) }[fit];
  const [sw, sh] = fit === "fill" ? [vw, vh] : [w * scale, h * scale];
  return { left: (vw - sw) / 2, top: (vh - sh) / 2, x: sw / w, y: sh / h };
}
/** Our pinhole, and the picture's place: px from the viewport's corner. */
function expected({ img_size, camera_matrix: [[fx, , cx], [, fy, cy]] }, viewport, fit, [x, y, z]) {
  const at = laidOut(img_size, viewport, fit);
  return [at.left + ((fx * x) / z + cx + 0.5) * at.x, at.top + ((fy * y) / z + cy + 0.5) * at.y];
}
function everywhere(check) {
  for (const camera of CAMERAS)
    for (const viewport of VIEWPORTS)
      for (const fit of FITS)
        for (const point of POINTS) {
          const [x, y] = check(camera, { viewport, fit }, point);
          const [u, v] = expected(camera, viewport, fit, point);
          assert.ok(
            Math.hypot(((x + 1) / 2) * viewport[0] - u, ((1 - y) / 2) * viewport[1] - v) < BOUND,
            `${viewport} ${fit} ${point}: ${x} ${y}, not ${u} ${v}`,
          );
        }
}

test("three.js projects as our pinhole does, and back", () => {
  const eye = new PerspectiveCamera(50, 1, 0.05, 500);
  everywhere((camera, layout, [x, y, z]) => {
    applyToThree(eye, camera, layout);
    const seen = new Vector3(x, -y, -z).project(eye);
    const back = seen.clone().unproject(eye);
    // In depth the way back is as good as the depth buffer's arithmetic; what matters is the ray.
    assert.ok(Math.hypot(back.x / -back.z - x / z, back.y / back.z - y / z) < 1e-12);
    return [seen.x, seen.y];
  });
});

test("what three.js does with its camera on the way does not undo it", () => {
  const eye = new PerspectiveCamera(50, 1, 0.05, 500);
  applyToThree(eye, CAMERAS[0]);
  eye.aspect = 3; // as every example does when a window is resized
  eye.updateProjectionMatrix();
  eye.updateMatrixWorld();
  const ndc = new Vector3(0.1, 0.2, -1.5).project(eye);
  const [u, v] = expected(CAMERAS[0], [1280, 720], "cover", [0.1, -0.2, 1.5]);
  assert.ok(Math.hypot(((ndc.x + 1) / 2) * 1280 - u, ((1 - ndc.y) / 2) * 720 - v) < BOUND);
  const pick = new Raycaster();
  pick.setFromCamera(new Vector2(ndc.x, ndc.y), eye);
  assert.ok(Math.abs(pick.ray.direction.x / pick.ray.direction.z + 0.1 / 1.5) < 1e-12);
});

test("depth is as three.js would have it, for every kind of depth buffer", () => {
  for (const [coordinateSystem, reversed] of [
    [undefined, false],
    [WebGPUCoordinateSystem, false],
    [undefined, true],
    [WebGPUCoordinateSystem, true],
  ]) {
    const [own, ours] = [0, 1].map(() => {
      const eye = new PerspectiveCamera(50, 1, 0.05, 500);
      if (coordinateSystem) eye.coordinateSystem = coordinateSystem;
      eye._reversedDepth = reversed; // set by the renderer
      eye.updateProjectionMatrix();
      return eye;
    });
    applyToThree(ours, CAMERAS[0]);
    for (const z of [0.05, 0.3, 20, 500]) {
      const depths = [own, ours].map((eye) => new Vector3(0, 0, -z).applyMatrix4(eye.projectionMatrix).z);
      assert.ok(Math.abs(depths[0] - depths[1]) < 1e-12, `${coordinateSystem} ${reversed} ${z}: ${depths}`);
    }
  }
});

for (const rightHanded of [false, true]) {
  test(`Babylon.js projects as our pinhole does, ${rightHanded ? "right" : "left"}-handed`, () => {
    const scene = new Scene(new NullEngine({ useHighPrecisionMatrix: true }));
    scene.useRightHandedSystem = rightHanded;
    const eye = new FreeCamera("eye", BabylonVector.Zero(), scene);
    if (rightHanded) eye.setTarget(new BabylonVector(0, 0, -1));
    everywhere((camera, layout, [x, y, z]) => {
      applyToBabylon(eye, camera, layout);
      const matrix = eye.getViewMatrix(true).multiply(eye.getProjectionMatrix());
      const point = new BabylonVector(x, -y, rightHanded ? -z : z);
      const seen = BabylonVector.TransformCoordinates(point, matrix);
      const back = BabylonVector.TransformCoordinates(seen, Matrix.Invert(matrix));
      assert.ok(Math.hypot(back.x / back.z - point.x / point.z, back.y / back.z - point.y / point.z) < 1e-12);
      return [seen.x, seen.y];
    });
    scene.getEngine().dispose();
  });
}

test("depth is Babylon.js', for every kind of depth buffer", () => {
  const engine = new NullEngine({ useHighPrecisionMatrix: true });
  const scene = new Scene(engine);
  for (const [reversed, half, maxZ] of [
    [false, false, 500],
    [true, false, 500],
    [false, true, 500],
    [true, true, 500],
    [false, false, 0],
  ]) {
    engine.useReverseDepthBuffer = reversed;
    const eye = new FreeCamera("eye", BabylonVector.Zero(), scene);
    [eye.minZ, eye.maxZ] = [0.05, maxZ];
    const own = eye.getProjectionMatrix(true).clone();
    Object.defineProperty(engine, "isNDCHalfZRange", { value: half, configurable: true }); // WebGPU's engine says so
    applyToBabylon(eye, CAMERAS[0]);
    for (const z of [0.05, 0.3, 20, 500]) {
      const [full, ours] = [own, eye.getProjectionMatrix()].map(
        (matrix) => BabylonVector.TransformCoordinates(new BabylonVector(0, 0, z), matrix).z,
      );
      const depths = [half ? (full + 1) / 2 : full, ours];
      assert.ok(Math.abs(depths[0] - depths[1]) < 1e-9, `${reversed} ${half} ${maxZ} ${z}: ${depths}`);
    }
    delete engine.isNDCHalfZRange;
  }
  engine.dispose();
});

test("A-Frame's component updates its camera on resize", () => {
  let definition;
  registerCalibrated({ registerComponent: (name, each) => (definition = { name, ...each }) });
  assert.deepEqual([definition.name, definition.dependencies], ["calibrated", ["camera"]]);
  const eye = new PerspectiveCamera(50, 1, 0.05, 500);
  const sceneEl = Object.assign(new EventTarget(), { canvas: { clientWidth: 1000, clientHeight: 1000 } });
  const component = Object.assign(Object.create(definition), {
    el: { sceneEl, getObject3D: () => eye },
    data: { fit: "contain" },
  });
  component.init();
  component.update();
  component.use(CAMERAS[0]);
  const expectView = (viewport) => {
    const [u] = expected(CAMERAS[0], viewport, "contain", [0.1, -0.2, 1.5]);
    assert.ok(Math.abs(new Vector3(0.1, 0.2, -1.5).project(eye).x - ((2 * u) / viewport[0] - 1)) < 1e-12);
  };
  const resize = (clientWidth, clientHeight) => {
    sceneEl.canvas = { clientWidth, clientHeight };
    sceneEl.dispatchEvent(new Event("rendererresize"));
  };
  expectView([1000, 1000]);
  resize(1600, 500);
  expectView([1600, 500]);
  component.remove();
  resize(500, 500);
  expectView([1600, 500]);
});
