// calibDB for web applications: the calibration of the camera that a page has open.
//
//     import { lookup } from "https://<host>/sdk/calibdb.js";
//     const { calibration, guidanceUrl } = await lookup(track, { token });

/**
 * @typedef {object} CameraKey what identifies the optics that a browser opened
 * @property {string} camera the track's label
 * @property {string} platform the parenthesised part of the user agent
 * @property {[number, number]} img_size width, height, px
 * @property {number} zoom 0 where the camera reports none
 *
 * @typedef {object} Adapted
 * @property {[number, number]} img_size
 * @property {number} zoom
 * @property {number[][]} camera_matrix
 * @property {number[]} distortion_coefficients
 * @property {boolean} interpolated between two calibrated zooms
 *
 * @typedef {object} Calibration
 * @property {[number, number]} img_size
 * @property {number[][]} camera_matrix row-major 3x3, px; the centre of the top-left pixel is (0, 0)
 * @property {number[]} distortion_coefficients in the order that the model's name says
 * @property {string} distortion_model "rectilinear" (k1 k2 p1 p2 k3), "fisheye" (k1 k2 k3 k4), …
 * @property {number} avg_reprojection_error rms over all measurements, px
 * @property {string | null} id
 * @property {string} camera
 * @property {string} platform
 * @property {number} zoom
 * @property {"consensus" | "checked" | null} [basis] what makes it reliable
 * @property {number | null} [spread] px rms between the calibrations that agree, over the image
 * @property {number | null} [held_out_error] px rms of views under a fit that did not see them
 * @property {"scale" | "crop" | "scale+crop" | "neither" | null} [relation] of this size to the one asked for, where verified
 * @property {Adapted | null} [adapted] parameters for the size or zoom asked for, where verified
 * @property {number} calibrations how many agree on this
 * @property {number} contributors
 * @property {boolean} reliable
 * @property {boolean} exact_size false: the closest known size, not the one asked for
 * @property {{rms: number, max: number}} uncertainty predicted projection error over the image, px
 * @property {number} calibration_time unix seconds
 *
 * @typedef {object} Answer
 * @property {Calibration | null} calibration null: nothing reliable is known
 * @property {string | null} guidanceUrl where this camera can be calibrated, when nothing is known
 * @property {string | null} reason "unknown_camera", "too_few", "disagree" or "few_contributors"
 *
 * @typedef {object} Options
 * @property {string} token API token
 * @property {string} [model] distortion model, "rectilinear" unless told
 * @property {string | URL} [api] address of the API; that of the host this file came from unless told
 * @property {AbortSignal} [signal]
 * @property {typeof globalThis.fetch} [fetch]
 */

/** The service answered, but not with an answer. */
export class LookupError extends Error {
  /** @param {string} message @param {number} status HTTP status */
  constructor(message, status) {
    super(message);
    this.name = "LookupError";
    this.status = status;
  }
}

/**
 * The platform as calibDB knows it: "X11; Linux x86_64".
 * @param {string} userAgent
 */
export function platformOf(userAgent) {
  return /\(([^)]*)\)/.exec(userAgent)?.[1] || userAgent.slice(0, 200) || "unknown";
}

/**
 * The platform of this browser. Chromium hides the device's model in its user agent and tells it when asked: then it
 * is written as the user agent used to, "Linux; Android 14; Pixel 8". Without it phones cannot be told apart.
 * @param {{userAgent: string, userAgentData?: unknown}} [browser]
 */
export async function platformHere(browser = navigator) {
  const data = /** @type {{getHighEntropyValues?: (hints: string[]) => Promise<Record<string, string>>} | undefined} */ (
    browser.userAgentData
  );
  try {
    const { model, platformVersion = "" } = (await data?.getHighEntropyValues?.(["model", "platformVersion"])) ?? {};
    if (model) return `Linux; Android ${platformVersion.split(".")[0]}; ${model}`;
  } catch {
    // refused by a permissions policy: the user agent is all there is
  }
  return platformOf(browser.userAgent);
}

/**
 * Which camera, at which resolution and zoom, a track shows.
 * @param {MediaStreamTrack} track of a camera that the user has permitted: without permission labels are empty
 * @param {string} [userAgent]
 * @returns {CameraKey}
 */
export function cameraKey(track, userAgent = navigator.userAgent) {
  const settings = /** @type {MediaTrackSettings & {zoom?: number}} */ (track.getSettings());
  if (!settings.width || !settings.height) throw new TypeError("the track shows no picture yet");
  return {
    camera: track.label || "unnamed camera",
    platform: platformOf(userAgent),
    img_size: [settings.width, settings.height],
    zoom: settings.zoom ?? 0,
  };
}

/**
 * Looks up the calibration of a camera.
 * @param {MediaStreamTrack | CameraKey} source an open camera, or what identifies it
 * @param {Options} options
 * @returns {Promise<Answer>} rejects with LookupError, or with what `fetch` rejects with
 */
export async function lookup(source, { token, model = "rectilinear", api, signal, fetch = globalThis.fetch }) {
  const key = "getSettings" in source ? await keyOf(source) : source;
  const address = new URL("lookup", `${api ?? new URL("../v1", import.meta.url)}/`.replace(/\/+$/, "/"));
  const response = await fetch(address, {
    method: "POST",
    headers: { authorization: `Bearer ${token}`, "content-type": "application/json" },
    // A redirect's Location is hidden from fetch(): ask for it in words.
    body: JSON.stringify({ ...key, distortion_model: model, redirect: false }),
    signal,
  });
  const body = /json/.test(response.headers.get("content-type") ?? "") ? await response.json() : {};
  if (response.ok) return { calibration: body, guidanceUrl: null, reason: null };
  if (response.status === 404 && body.guidance_url) {
    return { calibration: null, guidanceUrl: body.guidance_url, reason: body.reason ?? null };
  }
  throw new LookupError(body.detail ?? `calibDB answered ${response.status}`, response.status);
}

/** @param {MediaStreamTrack} track */
async function keyOf(track) {
  const { resizeMode } = /** @type {MediaTrackSettings & {resizeMode?: string}} */ (track.getSettings());
  const key = { ...cameraKey(track), platform: await platformHere() };
  // Of a stream that the browser crops nothing is known, whatever is known of its camera.
  return resizeMode ? { ...key, resize_mode: resizeMode } : key;
}
