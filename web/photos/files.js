// Photographs and frames of videos, one after the other, as the camera's sensor saw them.
import { cameraName, readExif, unturned } from "./exif.js";

/**
 * @typedef {object} Shot
 * @property {string} name
 * @property {ImageBitmap} picture
 * @property {string} camera its name; "" where the file does not say
 * @property {number} focal mm; 0
 * @property {"photographs" | "video"} kind
 * @property {number} share of the file that has been read with it, 0 to 1
 */

const MAX_FRAMES = 120; // of a video, for the time that it takes; every one of them counts that agrees with the others
const FRAMES_PER_S = 10;
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
 * @param {number} [most] frames of a video
 * @returns {AsyncGenerator<Shot>} throws UnreadableError
 */
export async function* shots(file, signal, most = MAX_FRAMES) {
  if (isVideo(file)) yield* frames(file, signal, most);
  else yield await photograph(file);
}

/** @param {File} file @returns {Promise<Shot>} */
async function photograph(file) {
  const bytes = await file.arrayBuffer();
  const exif = readExif(bytes);
  try {
    const picture = await createImageBitmap(new Blob([unturned(bytes, exif)], { type: file.type }));
    return { name: file.name, picture, camera: cameraName(exif), focal: exif.focal, kind: "photographs", share: 1 };
  } catch (error) {
    if (error instanceof DOMException) throw new UnreadableError(file);
    throw error;
  }
}

/** @param {File} file @param {AbortSignal} signal @param {number} most @returns {AsyncGenerator<Shot>} */
async function* frames(file, signal, most) {
  const video = document.createElement("video");
  video.muted = true;
  video.preload = "auto";
  video.src = URL.createObjectURL(file);
  try {
    await event(video, "loadeddata", file);
    const { duration } = video;
    const count = Number.isFinite(duration) ? Math.min(most, Math.max(1, Math.floor(duration * FRAMES_PER_S))) : 1;
    for (let index = 0; index < count && !signal.aborted; index++) {
      video.currentTime = ((index + 0.5) * duration) / count;
      await event(video, "seeked", file);
      const picture = await createImageBitmap(video);
      yield { name: `${file.name}, ${video.currentTime.toFixed(1)} s`, picture, camera: "", focal: 0, kind: "video", share: (index + 1) / count };
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

/** Words that cameras and programs put into names of files. */
const FILE_WORDS = /^(?:img|dsc[fn]?|pxl|dji|gopr\d+|gh\d\d|mvi|mov|vid|video|image|frame|frames|photo|photos|picture|pic|capture|captured|snapshot|screenshot|output|left|right|calib|calibration|board|charuco|chessboard|aprilgrid|test|scan|wp|p|s)$/i;
const MIN_NAME_LETTERS = 4;

/**
 * Camera by the names of its files: the words that they begin with alike, without numbers and dates.
 * @param {string[]} names
 * @returns {string} "" where they say nothing
 */
export function cameraOfNames(names) {
  const [first = "", ...others] = names.map((name) => name.replace(/\.[^.]*$/, "").split(/[_\s]+/).filter(Boolean));
  const common = [...first].filter((word, index) => others.every((words) => words[index] === word));
  const end = common.findIndex((word) => FILE_WORDS.test(word) || /^\d+$/.test(word) || /^\d{4}-?\d{2}/.test(word));
  // A size at the end of a word is no part of the name: "HD-3000-1280" is of pictures 1280 px wide.
  const words = common.slice(0, end < 0 ? undefined : end).map((word) => word.replace(/-(?:\d{3,4}x\d{3,4}|640|1280|1920|3840)$/, ""));
  const name = words.join(" ").trim();
  return (name.match(/\p{L}/gu)?.length ?? 0) >= MIN_NAME_LETTERS ? name.slice(0, 128) : "";
}
