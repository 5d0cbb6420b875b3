// A-Frame over the picture of a calibrated camera.
import { registerCalibrated } from "../../sdk/adapters/aframe.js";
import AFRAME from "../../vendor/engines/aframe.js";
import { MARK, drawingFor } from "../board.js";
import { whenOpen } from "../picture.js";

registerCalibrated(AFRAME);

whenOpen(({ pinhole, calibration, stage }) => {
  const { marks, edges } = drawingFor(calibration);
  const scene = /** @type {any} */ (make("a-scene", { embedded: "", background: "transparent: true", "xr-mode-ui": "enabled: false", "keyboard-shortcuts": "enterVR: false" }));
  const eye = make("a-entity", { camera: "near: 0.1; far: 1000", calibrated: "fit: cover", position: "0 0 0" });
  scene.append(eye);
  const at = (/** @type {readonly number[]} */ [x, y, z]) => `${x} ${-y} ${-z}`; // A-Frame has y up and looks along −z
  for (const point of marks) {
    scene.append(make("a-plane", { width: MARK, height: MARK, position: at(point), material: "shader: flat; color: #ffb000; toneMapped: false" }));
  }
  for (const [from, to] of edges) scene.append(make("a-entity", { line: `start: ${at(from)}; end: ${at(to)}; color: #7ee0ff` }));
  scene.addEventListener("loaded", () => /** @type {any} */ (eye).components.calibrated.use(pinhole));
  stage.append(scene);
  // A-Frame looks at the window's size only.
  new ResizeObserver(() => scene.hasLoaded && scene.resize()).observe(stage);
});

/** @param {string} name @param {Record<string, string | number>} attributes */
function make(name, attributes) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, String(value));
  return made;
}
