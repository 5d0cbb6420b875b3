// Photographs and frames of videos, one after the other, as the camera's sensor saw them.
import { cameraName, readExif, unturned } from "./exif.js";

/**
 * @typedef {object} Shot
 * @property {string} name
 * @property {ImageBitmap} picture
 * @property {string} camera its name; "" where the file does not say
 * @property {number} focal mm; 0
 * @property {"photographs" | "video"} kind
 */

const FRAMES = 60; // of a video
const PATIENCE = 15_000; // ms for one frame

/** The browser cannot read a file. */
export class UnreadableError extends Error {}

/**
 * @param {File} file
 * @param {AbortSignal} signal
 * @returns {AsyncGenerator<Shot>} throws UnreadableError
 */
export async function* shots(file, signal) {
  if (file.type.startsWith("video/")) yield* frames(file, signal);
  else yield await photograph(file);
}

/** @param {File} file @returns {Promise<Shot>} */
async function photograph(file) {
  const bytes = await file.arrayBuffer();
  const exif = readExif(bytes);
  try {
    const picture = await createImageBitmap(new Blob([unturned(bytes, exif)], { type: file.type }));
    return { name: file.name, picture, camera: cameraName(exif), focal: exif.focal, kind: "photographs" };
  } catch (error) {
    if (error instanceof DOMException) throw new UnreadableError(file.name);
    throw error;
  }
}

/** @param {File} file @param {AbortSignal} signal @returns {AsyncGenerator<Shot>} */
async function* frames(file, signal) {
  const video = document.createElement("video");
  video.muted = true;
  video.preload = "auto";
  video.src = URL.createObjectURL(file);
  try {
    await event(video, "loadeddata", file.name);
    const { duration } = video;
    const count = Number.isFinite(duration) ? Math.min(FRAMES, Math.max(1, Math.floor(duration * 10))) : 1;
    for (let index = 0; index < count && !signal.aborted; index++) {
      video.currentTime = ((index + 0.5) * duration) / count;
      await event(video, "seeked", file.name);
      const picture = await createImageBitmap(video);
      yield { name: `${file.name}, ${video.currentTime.toFixed(1)} s`, picture, camera: "", focal: 0, kind: "video" };
    }
  } finally {
    URL.revokeObjectURL(video.src);
    video.removeAttribute("src");
    video.load();
  }
}

/** @param {HTMLVideoElement} video @param {string} name @param {string} file @returns {Promise<void>} */
function event(video, name, file) {
  return new Promise((resolve, reject) => {
    const end = new AbortController();
    const timer = setTimeout(() => fail(), PATIENCE);
    const fail = () => {
      clearTimeout(timer);
      end.abort();
      reject(new UnreadableError(file));
    };
    video.addEventListener("error", fail, { signal: end.signal });
    video.addEventListener(name, () => {
      clearTimeout(timer);
      end.abort();
      resolve();
    }, { signal: end.signal });
  });
}
