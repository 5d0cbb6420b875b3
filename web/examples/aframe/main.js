// A-Frame over the picture of a calibrated camera.
import { registerCalibrated } from "../../sdk/adapters/aframe.js";
import AFRAME from "../../vendor/engines/aframe.js";
import { BOX, CENTRE, MARK, MARKS, poseMatrix } from "../board.js";
import { whenOpen } from "../picture.js";

registerCalibrated(AFRAME);

whenOpen(({ stage, pinhole, pose, onChange, onFrame }) => {
  const scene = /** @type {any} */ (
    make("a-scene", {
      embedded: "",
      background: "transparent: true",
      "xr-mode-ui": "enabled: false",
      "keyboard-shortcuts": "enterVR: false",
    })
  );
  const eye = /** @type {any} */ (
    make("a-entity", { camera: "near: 0.1; far: 1000", calibrated: "fit: cover", position: "0 0 0" })
  );
  const board = /** @type {any} */ (make("a-entity", {}));
  const at = (/** @type {readonly number[]} */ [x, y, z]) => `${x} ${-y} ${-z}`; // A-Frame has y up and looks along −z
  for (const point of MARKS) {
    board.append(
      make("a-plane", {
        width: MARK,
        height: MARK,
        position: at(point),
        material: "shader: flat; color: #ffb000; toneMapped: false",
      }),
    );
  }
  board.append(make("a-box", { width: BOX, height: BOX, depth: BOX, position: at(CENTRE), color: "#7ee0ff" }));
  scene.append(eye, board);
  scene.addEventListener("loaded", () => {
    board.object3D.matrixAutoUpdate = false;
    onChange(() => {
      scene.resize(); // A-Frame looks at the window's size only
      eye.components.calibrated.use(pinhole());
    });
    onFrame(() => board.object3D.matrix.fromArray(poseMatrix(pose(), -1)));
  });
  stage.append(scene);
});

/** @param {string} name @param {Record<string, string | number>} attributes */
function make(name, attributes) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, String(value));
  return made;
}
