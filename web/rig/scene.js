// Scene of the simulated rig: where its cameras stand, and where the board is for a target. A function of the rig's
// state alone, so that browsers that know nothing of each other show the same board. Pure.
import { composePoses, invertPose, perturbPose, seededRandom } from "../lib/pose.js";
import { setupFrom } from "../lib/virtual/setup.js";
import { matchPose } from "../lib/virtual/match.js";

/**
 * @import { Board } from "../lib/board.js"
 * @import { Pose } from "../lib/pose.js"
 * @import { Setup } from "../lib/virtual/setup.js"
 * @import { Target } from "./service.js"
 */

const CENTRE = 13; // squares from camera 0: the cameras stand on a circle about this point, and look at it
const STEP = 0.17; // rad between neighbours
const VARIATIONS = [0, 0.035, -0.03, 0.05, 0.02, -0.045, 0.06, -0.015]; // of the lenses, by position

/** Pose of a camera: camera 0 → camera. @param {number} position @returns {Pose} */
export function cameraPose(position) {
  if (position === 0) return { rvec: [0, 0, 0], tvec: [0, 0, 0] };
  const angle = STEP * Math.ceil(position / 2) * (position % 2 ? 1 : -1);
  const turn = composePoses(
    { rvec: [0, 0, 0.012 * position], tvec: [0, 0, 0] },
    composePoses({ rvec: [0.02 * (position % 3), 0, 0], tvec: [0, 0, 0] }, { rvec: [0, angle, 0], tvec: [0, 0, 0] }),
  );
  const place = [CENTRE * Math.sin(angle), 0.15 * position, CENTRE * (1 - Math.cos(angle))];
  return composePoses(turn, { rvec: [0, 0, 0], tvec: place.map((value) => -value) });
}

/**
 * Simulated camera at a position: each has a lens of its own.
 * @param {URLSearchParams} parameters
 * @param {number} position
 * @returns {Setup}
 */
export function setupAt(parameters, position) {
  const setup = setupFrom(parameters);
  const part = VARIATIONS[position % VARIATIONS.length];
  const {
    lens,
    size: [width],
  } = setup;
  return {
    ...setup,
    lens: {
      ...lens,
      fx: lens.fx * (1 + part),
      fy: lens.fy * (1 + part),
      cx: lens.cx - 0.3 * part * width,
      cy: lens.cy + 0.2 * part * width,
      k1: lens.k1 * (1 - 2 * part),
    },
  };
}

/**
 * Pose of the board before there is a target: in front of camera 0.
 * @param {Board} board
 * @param {Setup} setup of camera 0
 * @returns {Pose} board → camera 0, squares
 */
export function firstPose({ squares: [columns, rows] }, { lens, size: [width] }) {
  return { rvec: [0, 0, 0], tvec: [-columns / 2, -rows / 2, (1.6 * columns * lens.fx) / width] };
}

/**
 * Pose of the board held at a target: it covers the target in the first camera that has one.
 * @param {readonly Target[]} targets of the rig's cameras
 * @param {Board} board
 * @param {URLSearchParams} parameters of the address
 * @returns {Pose | null} board → camera 0, squares; null where no camera has a target
 */
export function boardPose(targets, board, parameters) {
  const [target] = [...targets].sort((a, b) => a.position - b.position);
  if (!target) return null;
  const setup = setupAt(parameters, target.position);
  const held = matchPose(board, setup.lens, target);
  const pose = composePoses(invertPose(cameraPose(target.position)), held);
  if (setup.error === 0) return pose;
  const [columns, rows] = board.squares;
  return perturbPose(pose, setup.error, seededRandom(seedOf(target)), [columns / 2, rows / 2, 0]);
}

/** The same in every browser. @param {Target} target */
function seedOf({ rvec, tvec }) {
  let hash = 0x811c9dc5; // FNV-1a
  for (const value of [...rvec, ...tvec]) hash = Math.imul(hash ^ Math.round(1e4 * value), 0x01000193) >>> 0;
  return hash;
}
