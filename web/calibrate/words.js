// What the page says about itself, by its state.

import { isVirtual } from "../virtual/camera.js";
import { fieldOfView } from "./result.js";

/** @typedef {import("./state.js").State} State */

/** @param {number} count */
const views = (count) => `${count} ${count === 1 ? "view" : "views"}`;

/** What is being waited for before a capture. @param {State} state */
export function opening({ waiting, patience, loading }) {
  if (patience > 0) return "The connection to calibDB is lost. Trying again.";
  if (waiting === "camera") return "Waiting for the camera. If your browser asks, allow it.";
  if (waiting === "service") return "Asking calibDB for a session.";
  return loading < 1 ? "Loading the board detector, 12 MB the first time." : "Starting the board detector.";
}

/** @param {State} state */
export function kept({ session }) {
  const count = session?.views.length ?? 0;
  if (count === 0) return "";
  return `${views(count)} ${count === 1 ? "is" : "are"} kept. Try again with the same camera to go on.`;
}

/** @param {State} state */
export function stopping({ stopAsked, session }) {
  return stopAsked === null ? "Stop" : `Stop and lose ${views(session?.views.length ?? 0)}?`;
}

/** @param {State} state */
export function counts({ session }) {
  const accuracy = session?.uncertainty ? ` · ± ${session.uncertainty.rms.toFixed(2)} px` : "";
  return `${views(session?.views.length ?? 0)}${accuracy}`;
}

/** @param {string} camera @param {[number, number] | null} size */
const described = (camera, size) => `${camera}${size ? ` at ${size.join(" × ")}` : ""}`;

/** What the page was opened for, and whether it is there. @param {State} state */
export function wanted({ wanted: { camera, img_size }, cameras }) {
  if (!camera) return "";
  const real = cameras.filter(({ id }) => id !== "virtual");
  const absent = !cameras.some(({ label }) => label === camera) && real.every(({ named }) => named);
  const missing = real.length ? "It is not among the cameras found here." : "No camera was found here: plug it in.";
  return `Asked for: ${described(camera, img_size)}${absent ? `. ${missing}` : ""}`;
}

/** That it is another camera which was opened; "" where it is the one. @param {State} state */
export function another({ wanted: { camera, img_size }, key }) {
  if (!camera || !key) return "";
  if (camera === key.camera && (img_size ?? key.img_size).join() === key.img_size.join()) return "";
  return `Asked for: ${described(camera, img_size)}. Opened: ${described(key.camera, key.img_size)}. ` +
    "What is measured here is about the opened one.";
}

/** What became of a finished capture. @param {State} state */
export function summary({ session, key }) {
  if (!session?.calibration) return "";
  const { horizontal, vertical } = fieldOfView(session.calibration);
  const meaning = isVirtual(key?.camera ?? "")
    ? "This was a practice run with a made-up camera: yours is still to be measured."
    : "The corner positions were added to the database: once five calibrations of this camera model agree, every web " +
      "page can look it up.";
  return `${views(session.views.length)}. The lens sees ${horizontal.toFixed(1)}° across and ${vertical.toFixed(1)}° ` +
    `down, distortion aside. ${meaning}`;
}
