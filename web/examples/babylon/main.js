// Babylon.js over the picture of a calibrated camera.
import { applyCalibration } from "../../sdk/adapters/babylon.js";
import { Color3, Color4, CreateLineSystem, CreatePlane, Engine, FreeCamera, Scene, StandardMaterial, Vector3 } from "../../vendor/engines/babylon.js";
import { MARK, drawingFor } from "../board.js";
import { whenOpen } from "../picture.js";

whenOpen(({ pinhole, calibration, stage, viewport }) => {
  const canvas = document.createElement("canvas");
  stage.append(canvas);
  const engine = new Engine(canvas, true, { alpha: true, premultipliedAlpha: true }, true);
  engine.canvasTabIndex = -1; // there is nothing to operate
  const scene = new Scene(engine);
  scene.clearColor = new Color4(0, 0, 0, 0);
  const camera = new FreeCamera("camera", Vector3.Zero(), scene); // at the origin, looking along z
  [camera.minZ, camera.maxZ] = [0.1, 1000];

  const { marks, edges } = drawingFor(calibration);
  const at = (/** @type {readonly number[]} */ [x, y, z]) => new Vector3(x, -y, z); // Babylon.js has y up
  const amber = new StandardMaterial("amber", scene);
  amber.emissiveColor = Color3.FromHexString("#ffb000");
  amber.disableLighting = true;
  for (const point of marks) {
    const mark = CreatePlane("mark", { size: MARK }, scene);
    mark.material = amber;
    mark.position = at(point);
  }
  CreateLineSystem("box", { lines: edges.map((edge) => edge.map(at)) }, scene).color = Color3.FromHexString("#7ee0ff");

  const resize = () => {
    engine.resize();
    applyCalibration(camera, pinhole, { viewport: viewport(), fit: "cover" });
  };
  new ResizeObserver(resize).observe(stage);
  resize();
  engine.runRenderLoop(() => scene.render());
});
