// Camera key: identifies the camera that a page has open.
/// <reference path="./dom.d.ts" preserve="true" />

/** `resize_mode` of a track whose picture is a part of the camera's. */
export const CROPPED = "crop-and-scale";

/**
 * @typedef {object} CameraKey what identifies the optics that a browser opened
 * @property {string} camera the track's label
 * @property {string} platform the parenthesised part of the user agent
 * @property {[number, number]} img_size width, height, px
 * @property {number} zoom 0 where the camera reports none
 * @property {string} [resize_mode] "crop-and-scale": the picture is a part of the camera's
 */

/**
 * The platform as calibDB knows it: "X11; Linux x86_64".
 * @param {string} userAgent
 */
export function platformOf(userAgent) {
  return /\(([^)]*)\)/.exec(userAgent)?.[1] || userAgent.slice(0, 200) || "unknown";
}

/**
 * The platform of this browser. Chromium's user agent hides the device's model, which a hint returns. The platform
 * has the earlier form, "Linux; Android 14; Pixel 8". Without the model, phones are indistinguishable.
 * @param {{userAgent: string, userAgentData?: unknown}} [browser]
 */
export async function platformHere(browser = navigator) {
  const data =
    /** @type {{getHighEntropyValues?: (hints: string[]) => Promise<Record<string, string>>} | undefined} */ (
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
 * The platform with a phone's model identifier, "iPhone17,3", which Safari does not say.
 * @param {string} platform @param {string} [device] "" or undefined: not known
 */
export function withDevice(platform, device) {
  if (!device || platform.split(";").some((part) => part.trim().toLowerCase() === device.toLowerCase()))
    return platform;
  return `${platform}; ${device}`;
}

/**
 * Camera, resolution and zoom of a track.
 * @param {MediaStreamTrack} track of a camera that the user has permitted: without permission labels are empty
 * @param {string} [userAgent]
 * @returns {CameraKey} throws a TypeError for a track that shows nothing
 */
export function cameraKey(track, userAgent = navigator.userAgent) {
  if (track.readyState === "ended") throw new TypeError("the track has ended: open the camera again");
  if (track.kind === "audio") throw new TypeError("the track is of a microphone: cameras are on getVideoTracks()");
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
 * The same with all hints that the browser gives on request.
 * @param {MediaStreamTrack | CameraKey} source a key is taken as it is, which is what a worker has
 * @param {string} [device] model identifier of the phone
 * @returns {Promise<CameraKey>} rejects with a TypeError for no camera, and for a track that shows nothing
 */
export async function keyOf(source, device) {
  if (!source) throw new TypeError("there is no camera: lookup(track) or lookup({ camera, platform, img_size, zoom })");
  if (!("getSettings" in source))
    return { ...source, platform: withDevice(source.platform, device), zoom: source.zoom ?? 0 };
  const { resizeMode } = /** @type {MediaTrackSettings & {resizeMode?: string}} */ (source.getSettings());
  const key = { ...cameraKey(source), platform: withDevice(await platformHere(), device) };
  // A stream that the browser crops is unknown, even if its camera is known.
  return resizeMode ? { ...key, resize_mode: resizeMode } : key;
}
