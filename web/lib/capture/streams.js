// Streams of this device's cameras, and the pictures that they deliver: a stereo camera's stream has two.
import { CameraError, facts, open, play, requestStream } from "../camera.js";
import { grab } from "../detector.js";
import { cameraKey, platformHere } from "../../sdk/key.js";

/**
 * @import { SessionRequest } from "../../vendor/api.js"
 * @import { OpenCamera } from "../camera.js"
 */

/**
 * @typedef {"one" | "side_by_side" | "top_bottom"} Layout of the pictures in a stream
 * @typedef {"left" | "right" | "top" | "bottom"} Half of a stream's picture
 *
 * @typedef {object} Choice a camera to be opened
 * @property {string} id of the device; "virtual" followed by a position for a simulated camera
 * @property {string} label
 * @property {Layout} layout
 * @property {SessionRequest["distortion_model"]} distortion_model
 *
 * @typedef {object} Picture one camera's part of a stream
 * @property {Half | null} half null: all of it
 * @property {[number, number]} size px
 * @property {[number, number]} offset of its first pixel in the stream's picture, px
 * @property {SessionRequest["track"]} track
 * @property {string} camera label, with the half
 * @property {string} platform
 * @property {number} zoom
 */

/** @type {Record<Layout, (Half | null)[]>} */
export const HALVES = { one: [null], side_by_side: ["left", "right"], top_bottom: ["top", "bottom"] };
/** Sizes to ask a camera for, px. @type {Record<Layout, [number, number]>} */
const ASKED_SIZES = { one: [1280, 720], side_by_side: [2560, 720], top_bottom: [1280, 1440] };

/**
 * Place of a half in the stream's picture.
 * @param {Half | null} half @param {[number, number]} whole px
 * @returns {{size: [number, number], offset: [number, number]}} px
 */
export function placeOf(half, [width, height]) {
  const size = /** @type {[number, number]} */ ([
    half === "left" || half === "right" ? width >> 1 : width,
    half === "top" || half === "bottom" ? height >> 1 : height,
  ]);
  return { size, offset: [half === "right" ? width - size[0] : 0, half === "bottom" ? height - size[1] : 0] };
}

/**
 * Label of one half: another lens is another camera. The USB id stays at the end.
 * @param {string} label
 * @param {Half | null} half
 */
export function labelOfHalf(label, half) {
  return half ? label.replace(/(\s*\([0-9a-f]{4}:[0-9a-f]{4}\))?$/i, (id) => ` ${half}${id}`) : label;
}

export class Stream {
  /** @type {{video: HTMLVideoElement, picture: Picture}[]} */
  #shown = [];

  #layout;

  /** @param {OpenCamera} camera @param {Layout} [layout] */
  constructor(camera, layout = "one") {
    this.camera = camera;
    this.#layout = layout;
  }

  /** @returns {boolean} whether it is shown as a mirror */
  get mirrored() {
    return this.camera.mirrored && this.#layout === "one";
  }

  /**
   * Plays the stream in a video for each of its pictures.
   * @param {HTMLVideoElement[]} videos @returns {Promise<Picture[]>}
   */
  async play(videos) {
    const { stream, track } = this.camera;
    for (const video of videos) await play(video, stream);
    // The frames' size counts: on a turned device some browsers' settings still give the sensor's.
    const { videoWidth, videoHeight } = videos[0];
    const key = cameraKey(track);
    const platform = await platformHere();
    const pictures = HALVES[this.#layout].map((half) => ({
      half,
      ...placeOf(half, [videoWidth, videoHeight]),
      track: facts(track),
      camera: labelOfHalf(key.camera, half),
      platform,
      zoom: key.zoom ?? 0,
    }));
    this.#shown = pictures.map((picture, index) => ({ picture, video: videos[index] }));
    return pictures;
  }

  /** True if the stream still delivers pictures of the size that it began with. */
  get unchanged() {
    const [{ video, picture }] = this.#shown;
    const { size } = placeOf(picture.half, [video.videoWidth, video.videoHeight]);
    return String(size) === String(picture.size);
  }

  /**
   * The stream's pictures now, all of the same moment.
   * @returns {Promise<(VideoFrame | ImageBitmap)[]>} to be closed by the caller
   */
  async grab() {
    const [{ video }] = this.#shown;
    const whole = await grab(video);
    if (this.#shown.length === 1) return [whole];
    try {
      return await Promise.all(
        this.#shown.map(({ picture: { offset, size } }) => createImageBitmap(whole, ...offset, ...size)),
      );
    } finally {
      whole.close();
    }
  }

  /** The video that new frames are waited for in. */
  get video() {
    return this.#shown[0].video;
  }

  close() {
    this.camera.close();
  }

  /**
   * Closes the camera when a capture ends, and reports if it is unplugged before.
   * @param {AbortSignal} signal of the capture; throws its reason if it has ended already
   * @param {(error: CameraError) => void} onUnplugged
   * @returns {() => void} keeps the camera open for another capture
   */
  closeWith(signal, onUnplugged) {
    const close = () => this.close();
    if (signal.aborted) close();
    signal.throwIfAborted();
    signal.addEventListener("abort", close);
    this.camera.track.addEventListener("ended", () => onUnplugged(new CameraError("unplugged")), { signal });
    return () => signal.removeEventListener("abort", close);
  }
}

/**
 * @param {Choice} choice
 * @param {{parameters: URLSearchParams, place: HTMLElement, board: import("../board.js").Board}} options
 * @returns {Promise<Stream>} rejects with CameraError
 */
export async function openStream(choice, options) {
  const asked = { ...options, size: ASKED_SIZES[choice.layout] };
  try {
    return new Stream(await open(choice.id, asked), choice.layout);
  } catch (error) {
    if (!(error instanceof CameraError) || error.code !== "gone") throw error;
    // Some browsers give devices new ids with each visit: the name is the same.
    const id = await idOf(choice.label);
    if (!id) throw error;
    return new Stream(await open(id, asked), choice.layout);
  }
}

/** Id of the device with a name; null where there is none. @param {string} label */
async function idOf(label) {
  const permission = await requestStream(true); // without it devices have no names
  const devices = await navigator.mediaDevices.enumerateDevices();
  for (const track of permission.getTracks()) track.stop();
  return devices.find((each) => each.kind === "videoinput" && each.label === label)?.deviceId ?? null;
}
