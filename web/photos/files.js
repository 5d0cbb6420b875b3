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
const FRAME_TIMEOUT_MS = 15_000; // ms for one frame

/** Formats that browsers cannot read, by file name ending. @type {[RegExp, string][]} */
const KNOWN = [
  [/\.(heic|heif)$/i, "heic"],
  [/\.(arw|cr2|cr3|dng|nef|orf|raf|rw2)$/i, "raw"],
  [/\.(mp4|mov|m4v|mkv|webm|avi|3gp)$/i, "video"],
];
const endingOf = (/** @type {string} */ name) => KNOWN.find(([ending]) => ending.test(name))?.[1] ?? "";

/** The browser cannot read a file. */
export class UnreadableError extends Error {
  /** @param {{name: string, type: string}} file */
  constructor({ name, type }) {
    super(name);
    const kind = type.split("/")[0];
    /** @type {"heic" | "raw" | "video" | "image" | "other"} what it is, as far as its name and type tell */
    this.code = /** @type {any} */ (endingOf(name) || (kind === "video" || kind === "image" ? kind : "other"));
  }
}

/** Files of cards and some phones come without a type. @param {File} file */
const isVideo = ({ type, name }) => type.startsWith("video/") || (type === "" && endingOf(name) === "video");

/**
 * @param {File} file
 * @param {AbortSignal} signal
 * @returns {AsyncGenerator<Shot>} throws UnreadableError
 */
export async function* shots(file, signal) {
  if (isVideo(file)) yield* frames(file, signal);
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
    if (error instanceof DOMException) throw new UnreadableError(file);
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
    await event(video, "loadeddata", file);
    const { duration } = video;
    const count = Number.isFinite(duration) ? Math.min(FRAMES, Math.max(1, Math.floor(duration * 10))) : 1;
    for (let index = 0; index < count && !signal.aborted; index++) {
      video.currentTime = ((index + 0.5) * duration) / count;
      await event(video, "seeked", file);
      const picture = await createImageBitmap(video);
      yield { name: `${file.name}, ${video.currentTime.toFixed(1)} s`, picture, camera: "", focal: 0, kind: "video" };
    }
  } finally {
    URL.revokeObjectURL(video.src);
    video.removeAttribute("src");
    video.load();
  }
}

/** @param {HTMLVideoElement} video @param {string} name @param {File} file @returns {Promise<void>} */
function event(video, name, file) {
  return new Promise((resolve, reject) => {
    const end = new AbortController();
    const timer = setTimeout(() => fail(), FRAME_TIMEOUT_MS);
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
