// WebXR that knows the camera of a video. Three lines of a page:
//
//     import { useCamera } from "https://<host>/webxr/camera.js";
//     await useCamera(video, { token });
//     const session = await navigator.xr.requestSession("immersive-ar");
//
// Its views have cameraMatrix, distortionCoefficients and distortionModel (extension.js). If the browser has no
// augmented reality of its own, the session shows the video and projects as its camera does.
import { watch, lookup } from "../sdk/lookup.js";
import { extend, isNeeded } from "./extension.js";

/**
 * @import { Calibration } from "../sdk/calibration.js"
 * @import { Answer } from "../sdk/lookup.js"
 * @import { Rectifier } from "../sdk/rectifier.js"
 */

/**
 * @typedef {object} More
 * @property {boolean} [rectify] show the picture straightened, so that a scene lies on it to its corners
 * @property {() => Float32Array | null} [pose] see device.js
 * @property {HTMLElement} [place]
 * @property {(answer: Answer) => void} [onAnswer] called with the answer for the camera, and again whenever its
 *   picture changes
 * @property {(error: unknown) => void} [onError] called with the error of a lookup; the views stay as they were
 *
 * @typedef {import("../sdk/lookup.js").Options & More} Options
 */

let installed = false;

/**
 * Extends WebXR, puts the video in the place of a device where there is none, and looks the video's camera up. A
 * second call is for another camera, or another way to show it: sessions that begin after it are of that.
 * @param {HTMLVideoElement} video showing a camera that the user has permitted
 * @param {Options} options
 * @returns {Promise<() => void>} ends the watch for changes of the picture; rejects with a TypeError where the video
 *   shows no camera
 */
export async function useCamera(video, { rectify = false, pose, place, onAnswer, onError = console.warn, ...options }) {
  const track = video.srcObject instanceof MediaStream ? video.srcObject.getVideoTracks()[0] : undefined;
  if (!track) throw new TypeError("the video shows no camera: give it a stream of getUserMedia() first");
  /** @type {Calibration | null} */
  let known = null;
  // The phone was just turned: until the next answer, the intrinsics are those of another picture.
  const holds = (/** @type {import("./extension.js").Intrinsics} */ { img_size: size }) =>
    size?.[0] === video.videoWidth && size[1] === video.videoHeight;
  const current = () => (known && holds(known) ? known : null);
  const straightened = rectify ? await straightening(onError) : undefined;
  if (installed || (await isNeeded())) {
    installed = true;
    const { install } = await import("./install.js");
    install({ video, pinhole: current, pose, place, straight: straightened && (() => straightened(current())) });
  }
  // Only intrinsics of exactly this picture: a view's matrix is in its pixels.
  const wish = { ...options, exact: true };
  const again = extend(
    async (_, model, size) => {
      if (size) return null; // raw camera access shows another picture than the video, and the browser knows that one
      return (await lookup(track, { ...wish, onNeedCalibration: undefined, model })).calibration;
    },
    { model: options.model, onError, holds },
  );
  return watch(track, wish, (answer) => {
    if (answer instanceof Error) return onError(answer);
    known = answer.calibration;
    void again();
    onAnswer?.(answer);
  });
}

/**
 * @param {(error: unknown) => void} onError
 * @returns {Promise<(known: Calibration | null) => Rectifier | null>} one for each calibration
 */
async function straightening(onError) {
  const { Rectifier } = await import("../sdk/rectifier.js");
  /** @type {Calibration | null} */
  let of = null;
  /** @type {Rectifier | null} */
  let rectifier = null;
  return (known) => {
    if (known === of) return rectifier;
    of = known;
    rectifier?.dispose();
    rectifier = null;
    try {
      rectifier = known && new Rectifier(known);
    } catch (error) {
      onError(error); // no WebGL2: the picture is shown as it is
    }
    return rectifier;
  };
}
