// 3D picture of two cameras and the four poses that a capture asks for, as an illustration.
import { DEFAULT_BOARD } from "./board.js";
import { onLanguage, t } from "./i18n.js";
import { sceneOf, scenePlot } from "./scene-plot.js";

/** @type {[number, number]} */
export const SIZE = [640, 360];
export const LENS = {
  camera_matrix: [
    [460, 0, 320],
    [0, 460, 180],
    [0, 0, 1],
  ],
  distortion_model: "rectilinear",
  distortion_coefficients: [-0.22, 0.05, 0, 0, 0],
};
/** Poses that a capture asks for, of a board nine squares wide; in squares. @type {import("./pose.js").Pose[]} */
export const TARGETS = [
  { rvec: [0, 0.6, 0.05], tvec: [-5.6, -3.6, 11] },
  { rvec: [-0.65, 0, 0], tvec: [-1.2, -3.2, 11.5] },
  { rvec: [0.1, -0.65, -0.2], tvec: [-3.4, -1.6, 12.5] },
  { rvec: [0, 0, 0], tvec: [-4.5, -3.2, 8.6] },
];
const STATIONS = [
  { position: 0, rvec: [0, 0, 0], tvec: [0, 0, 0] },
  { position: 1, rvec: [0, 0.5, 0], tvec: [-6, 0, 1.5] },
];

/** Shows it in an element, in each language. @param {HTMLElement} place */
export function showRigPicture(place) {
  const lenses = STATIONS.map(() => ({ ...LENS, img_size: SIZE }));
  const scene = sceneOf(lenses, STATIONS, TARGETS, DEFAULT_BOARD, 1);
  const draw = () => place.replaceChildren(scenePlot(scene, t("landing.rig")));
  onLanguage(draw);
  draw();
}
