// three.js over the picture of a calibrated camera.
import { applyCalibration } from "../../sdk/adapters/three.js";
import {
  BoxGeometry, EdgesGeometry, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, PerspectiveCamera, PlaneGeometry, Scene, WebGLRenderer,
} from "../../vendor/engines/three.js";
import { MARK, drawingFor } from "../board.js";
import { whenOpen } from "../picture.js";

whenOpen(({ pinhole, calibration, stage, viewport }) => {
  const renderer = new WebGLRenderer({ alpha: true, antialias: true });
  stage.append(renderer.domElement);
  const scene = new Scene();
  const camera = new PerspectiveCamera();
  [camera.near, camera.far] = [0.1, 1000];

  const { marks } = drawingFor(calibration);
  for (const [x, y, z] of marks) {
    const mark = new Mesh(new PlaneGeometry(MARK, MARK), new MeshBasicMaterial({ color: "#ffb000" }));
    mark.position.set(x, -y, -z); // three.js has y up and looks along −z
    scene.add(mark);
  }
  const [[left, top, z], , [right, bottom]] = marks;
  const box = new LineSegments(new EdgesGeometry(new BoxGeometry(right - left, bottom - top, 2)), new LineBasicMaterial({ color: "#7ee0ff" }));
  box.position.set(0, 0, 1 - z);
  scene.add(box);

  const resize = () => {
    renderer.setPixelRatio(devicePixelRatio);
    renderer.setSize(...viewport());
    applyCalibration(camera, pinhole, { viewport: viewport(), fit: "cover" });
  };
  new ResizeObserver(resize).observe(stage);
  resize();
  renderer.setAnimationLoop(() => renderer.render(scene, camera));
});
