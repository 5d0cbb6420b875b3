// Photographs and frames of videos, one after the other, as the camera's sensor saw them.
import { cameraName, readExif, unturned } from "./exif.js";
import { sizeOf } from "./card.js";
import { playedFrames } from "./video-frames.js";

/**
 * @typedef {object} Shot
 * @property {string} name
 * @property {ImageBitmap | VideoFrame} picture
 * @property {string} camera its name; "" where the file does not say
 * @property {number} focal mm; 0
 * @property {number} [focal35] mm, its equivalent on 35 mm film; 0
 * @property {"photographs" | "video"} kind
 * @property {number} share of the file that has been read with it, 0 to 1
 */

const MAX_FRAMES = 120; // of a video, for the time that it takes; every one of them counts that agrees with the others
const FRAMES_PER_S = 10; // of a video whose frames the browser does not name
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

/** Command that converts a video to what every browser reads. @param {string} name of the file */
export function conversion(name) {
  const quoted = (/** @type {string} */ text) => `"${text.replace(/["$\\`]/g, "\\$&")}"`;
  const converted = `${name.replace(/\.[^.]*$/, "")}-h264.mp4`;
  return `ffmpeg -i ${quoted(name)} -an -c:v libx264 -crf 16 -pix_fmt yuv420p ${quoted(converted)}`;
}

/** Files of cards and some phones come without a type. @param {File} file */
const isVideo = ({ type, name }) => type.startsWith("video/") || (type === "" && endingOf(name) === "video");

/**
 * @param {File} file @param {AbortSignal} signal
 * @param {{samples?: number, mirrored?: boolean}} [options] samples: so many frames from all over a video, else all,
 *   or as many as time allows; mirrored: the pictures are, and are turned back
 * @returns {AsyncGenerator<Shot>} throws UnreadableError
 */
export async function* shots(file, signal, { samples = 0, mirrored = false } = {}) {
  for await (const shot of isVideo(file) ? frames(file, signal, samples) : [await photograph(file)]) {
    yield mirrored ? { ...shot, picture: turnedBack(shot.picture) } : shot;
  }
}

/** @param {ImageBitmap | VideoFrame} picture let go of */
function turnedBack(picture) {
  const [width, height] = sizeOf(picture);
  const canvas = new OffscreenCanvas(width, height);
  const context = canvas.getContext("2d");
  context?.transform(-1, 0, 0, 1, width, 0);
  context?.drawImage(picture, 0, 0);
  picture.close();
  return canvas.transferToImageBitmap();
}

/** @param {File} file @returns {Promise<Shot>} */
async function photograph(file) {
  const bytes = await file.arrayBuffer();
  const exif = readExif(bytes);
  try {
    const picture = await createImageBitmap(new Blob([unturned(bytes, exif)], { type: file.type }));
    return {
      name: file.name,
      picture,
      camera: cameraName(exif),
      focal: exif.focal,
      focal35: exif.focal35,
      kind: "photographs",
      share: 1,
    };
  } catch (error) {
    if (error instanceof DOMException) throw new UnreadableError(file);
    throw error;
  }
}

/**
 * @param {File} file
 * @param {AbortSignal} signal
 * @param {number} samples 0: all frames
 * @returns {AsyncGenerator<Shot>}
 */
async function* frames(file, signal, samples) {
  const video = document.createElement("video");
  video.muted = true;
  video.preload = "auto";
  video.src = URL.createObjectURL(file);
  try {
    await event(video, "loadeddata", file);
    const { duration } = video;
    const isPlayed = samples === 0 && "requestVideoFrameCallback" in video;
    for await (const { time, picture } of isPlayed
      ? playedFrames(video, MAX_FRAMES, signal)
      : sampledFrames(video, file, samples, signal)) {
      yield {
        name: `${file.name}, ${time.toFixed(2)} s`,
        picture,
        camera: "",
        focal: 0,
        kind: "video",
        share: Math.min(1, time / duration || 0),
      };
    }
  } finally {
    URL.revokeObjectURL(video.src);
    video.removeAttribute("src");
    video.load();
  }
}

/**
 * @param {HTMLVideoElement} video
 * @param {File} file
 * @param {number} samples
 * @param {AbortSignal} signal
 * @returns {AsyncGenerator<import("./video-frames.js").VideoPicture>}
 */
async function* sampledFrames(video, file, samples, signal) {
  const { duration } = video;
  const count = !Number.isFinite(duration)
    ? 1
    : samples || Math.min(MAX_FRAMES, Math.max(1, Math.floor(duration * FRAMES_PER_S)));
  for (let index = 0; index < count && !signal.aborted; index++) {
    video.currentTime = ((index + 0.5) * duration) / count;
    await event(video, "seeked", file);
    yield { time: video.currentTime, picture: await createImageBitmap(video) };
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
    video.addEventListener(
      name,
      () => {
        clearTimeout(timer);
        end.abort();
        resolve();
      },
      { signal: end.signal },
    );
  });
}

/** Words that cameras and programs put into names of files. */
const FILE_WORDS = new RegExp(
  [
    String.raw`^(?:img|dsc[fn]?|pxl|dji|gopr\d+|gh\d\d|mvi|mov|vid|video|image|frame|frames|photo|photos|picture|pic`,
    "capture|captured|snapshot|screenshot|output|left|right|calib|calibration|board|charuco|chessboard|aprilgrid",
    "test|scan|wp|p|s)$",
  ].join("|"),
  "i",
);
const MIN_NAME_LETTERS = 4;

/**
 * Camera by the names of its files: the words that they begin with alike, without numbers and dates.
 * @param {string[]} names
 * @returns {string} "" where they say nothing
 */
export function cameraOfNames(names) {
  const [first = "", ...others] = names.map((name) =>
    name
      .replace(/\.[^.]*$/, "")
      .split(/[_\s]+/)
      .filter(Boolean),
  );
  const common = [...first].filter((word, index) => others.every((words) => words[index] === word));
  const end = common.findIndex((word) => FILE_WORDS.test(word) || /^\d+$/.test(word) || /^\d{4}-?\d{2}/.test(word));
  // A size at the end of a word is no part of the name: "HD-3000-1280" is of pictures 1280 px wide.
  const words = common
    .slice(0, end < 0 ? undefined : end)
    .map((word) => word.replace(/-(?:\d{3,4}x\d{3,4}|640|1280|1920|3840)$/, ""));
  const name = words.join(" ").trim();
  return (name.match(/\p{L}/gu)?.length ?? 0) >= MIN_NAME_LETTERS ? name.slice(0, 128) : "";
}
