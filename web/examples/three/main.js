// three.js over the picture of a calibrated camera.
import { applyCalibration } from "../../sdk/adapters/three.js";
import {
  BoxGeometry,
  Group,
  Mesh,
  MeshBasicMaterial,
  PerspectiveCamera,
  PlaneGeometry,
  Scene,
  WebGLRenderer,
} from "../../vendor/engines/three.js";
import { BOX, CENTRE, MARK, MARKS, poseMatrix } from "../board.js";
import { whenOpen } from "../picture.js";

const SIDES = ["#4fb6d8", "#3a8fae", "#9be4fb", "#2f7690", "#7ee0ff", "#235a70"];

whenOpen(({ stage, pinhole, viewport, pose, onChange, onFrame }) => {
  const renderer = new WebGLRenderer({ alpha: true, antialias: true });
  stage.append(renderer.domElement);
  const scene = new Scene();
  const camera = new PerspectiveCamera();
  [camera.near, camera.far] = [0.1, 1000];

  const board = new Group();
  board.matrixAutoUpdate = false;
  scene.add(board);
  for (const [x, y, z] of MARKS) {
    const mark = new Mesh(new PlaneGeometry(MARK, MARK), new MeshBasicMaterial({ color: "#ffb000" }));
    mark.position.set(x, -y, -z); // three.js has y up and looks along −z
    board.add(mark);
  }
  const box = new Mesh(
    new BoxGeometry(BOX, BOX, BOX),
    SIDES.map((color) => new MeshBasicMaterial({ color })),
  );
  const [x, y, z] = CENTRE;
  box.position.set(x, -y, -z);
  board.add(box);

  onChange(() => {
    renderer.setPixelRatio(devicePixelRatio);
    renderer.setSize(...viewport());
    applyCalibration(camera, pinhole(), { viewport: viewport(), fit: "cover" });
  });
  onFrame(() => {
    board.matrix.fromArray(poseMatrix(pose(), -1));
    renderer.render(scene, camera);
  });
});
