// WebXR with two eyes: the rectified pictures of two cameras side by side, and views that see as they do.
//
//     import { rig } from "https://<host>/sdk/calibdb.js";
//     import { useRig } from "https://<host>/webxr/rig.js";
//     await useRig(leftVideo, rightVideo, await rig(id, { token }));
//     const session = await navigator.xr.requestSession("immersive-ar"); // frames have a view for each eye
import { rectifyPair } from "../sdk/rig.js";
import { extend } from "./extension.js";
import { install } from "./install.js";

/**
 * @import { Packing, PairRectifier } from "../sdk/pair-rectifier.js"
 * @import { Rig } from "../sdk/rig.js"
 */

/**
 * @typedef {object} Options
 * @property {readonly [number, number]} [positions] of left and right camera in the rig; [0, 1] by default
 * @property {number} [squareSize] metres, of a rig in squares: WebXR is in metres
 * @property {Packing} [packing] of a stereo camera that delivers both pictures in
 *   one video
 * @property {() => Float32Array | null} [pose] of the left video's camera, see device.js
 * @property {HTMLElement} [place]
 */

/**
 * Puts two cameras in the place of `navigator.xr`, for the sessions that begin after it. Scenes lie on the rectified
 * pictures; the views' cameraMatrix and distortion are those of the cameras' own pictures.
 * @param {HTMLVideoElement} left
 * @param {HTMLVideoElement} right the same one, of a camera that delivers both pictures in it
 * @param {Rig} rig
 * @param {Options} [options]
 * @returns {Promise<PairRectifier>} the pair that is shown; rejects as `rectifyPair`
 *   does, and with a
 *   TypeError for a rig in squares without their size
 */
export async function useRig(left, right, rig, { positions = [0, 1], squareSize, packing, pose, place } = {}) {
  const metric = rig.toMetres(squareSize);
  const pair = await rectifyPair(left, right, metric, { positions, packing });
  const isSwapped = pair.baseline < 0; // the first of the two cameras is the right eye
  const canvases = isSwapped ? [pair.right, pair.left] : [pair.left, pair.right];
  const [one, other] = (isSwapped ? [...positions].reverse() : positions).map(
    (position) => metric.calibrations[position],
  );
  const element = document.createElement("div");
  for (const canvas of canvases)
    Object.assign(canvas.style, { width: "50%", height: "100%", objectFit: "cover", verticalAlign: "top" });
  element.append(...canvases);
  install({
    video: left,
    pinhole: () => metric.calibrations[positions[0]],
    pose,
    place,
    eyes: { element, draw: () => pair.draw(), views: (options) => pair.views(options) },
  });
  extend(async () => ({ left: one, right: other }));
  return pair;
}
