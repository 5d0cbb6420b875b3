// Two simulated cameras that look at one board, and the truth about them.
import { compose, invert, rigidMotion, rotate, rotationVectorOf } from "../../sdk/motion.js";
import { VirtualCamera, trueCalibration } from "../../lib/virtual/camera.js";
import { setupFrom } from "../../lib/virtual/setup.js";
import { poseAt } from "../board.js";

/** @typedef {import("../../lib/pose.js").Pose} Pose */

/** Left camera → right camera: next to it, and turned towards it; squares. */
const POSE = { rvec: [0.03, 0.09, 0.04], tvec: [-1.5, 0.12, 0.1] };
const LENSES = ["img_size=640x480&fx=500&k1=-0.3&k2=0.08&error=0", "img_size=640x480&fx=560&k1=-0.12&k2=0&error=0"];
const MOMENT_S = 1.4; // s of the board's motion at which it is shown: tilted

/** @param {HTMLElement} place of the canvases on which the cameras paint */
export async function openPair(place) {
  const setups = LENSES.map((lens) => setupFrom(new URLSearchParams(lens)));
  const [left, right] = setups.map(trueCalibration);
  const cameras = setups.map((setup) => new VirtualCamera(setup, place));
  for (const camera of cameras) await camera.open();
  const board = poseAt(left, MOMENT_S);
  const { r, t } = compose(rigidMotion(POSE), rigidMotion(board));
  const poses = [board, { rvec: rotationVectorOf(r), tvec: [...t] }];
  cameras.forEach((camera, index) => camera.hold(poses[index]));
  // The cameras paint at their own pace.
  while (cameras.some((camera, index) => camera.shown !== poses[index])) await new Promise(requestAnimationFrame);
  return { canvases: cameras.map(({ canvas }) => canvas), calibrations: { left, right, pose: POSE }, board };
}

/**
 * Distance along a ray of the left camera to the board's plane.
 * @param {readonly number[]} direction @param {Pose} board board → camera
 * @returns {number} lengths of the direction
 */
export function distanceToBoard(direction, board) {
  const motion = rigidMotion(board);
  const { r, t } = invert(motion);
  return -t[2] / rotate(r, direction)[2];
}
