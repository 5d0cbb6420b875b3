// Babylon.js over the picture of a calibrated camera.
import { applyCalibration } from "../../sdk/adapters/babylon.js";
import {
  Color3,
  Color4,
  CreateBox,
  CreatePlane,
  Engine,
  FreeCamera,
  HemisphericLight,
  Matrix,
  Quaternion,
  Scene,
  StandardMaterial,
  TransformNode,
  Vector3,
} from "../../vendor/engines/babylon.js";
import { BOX, CENTRE, MARK, MARKS, poseMatrix } from "../board.js";
import { whenOpen } from "../picture.js";

whenOpen(({ stage, pinhole, viewport, pose, onChange, onFrame }) => {
  const canvas = document.createElement("canvas");
  stage.append(canvas);
  const engine = new Engine(canvas, true, { alpha: true, premultipliedAlpha: true }, true);
  engine.canvasTabIndex = -1; // there is nothing to operate
  const scene = new Scene(engine);
  scene.clearColor = new Color4(0, 0, 0, 0);
  const camera = new FreeCamera("camera", Vector3.Zero(), scene); // at the origin, looking along z
  [camera.minZ, camera.maxZ] = [0.1, 1000];
  new HemisphericLight("light", new Vector3(0.5, 1, -0.5), scene);

  const board = new TransformNode("board", scene);
  board.rotationQuaternion = Quaternion.Identity();
  const amber = new StandardMaterial("amber", scene);
  amber.emissiveColor = Color3.FromHexString("#ffb000");
  amber.disableLighting = true;
  const at = (/** @type {readonly number[]} */ [x, y, z]) => new Vector3(x, -y, z); // Babylon.js has y up
  for (const point of MARKS) {
    const mark = CreatePlane("mark", { size: MARK }, scene);
    mark.material = amber;
    mark.position = at(point);
    mark.parent = board;
  }
  const blue = new StandardMaterial("blue", scene);
  blue.diffuseColor = Color3.FromHexString("#7ee0ff");
  blue.specularColor = Color3.Black();
  const box = CreateBox("box", { size: BOX }, scene);
  box.material = blue;
  box.position = at(CENTRE);
  box.parent = board;

  onChange(() => {
    engine.resize();
    applyCalibration(camera, pinhole(), { viewport: viewport(), fit: "cover" });
  });
  onFrame(() => {
    Matrix.FromArray(poseMatrix(pose(), 1)).decompose(undefined, board.rotationQuaternion, board.position);
    scene.render();
  });
});
