// Source of the open camera's calibration: a capture just made, a lookup, or the virtual camera's truth.
import { askJson } from "../lib/api.js";
import { sdkOptions } from "../lib/settings.js";
import { LookupError, lookup, returned } from "../sdk/calibdb.js";
import { isVirtual } from "../lib/camera-name.js";
import { trueCalibration } from "../lib/virtual/camera.js";
import { setupFrom } from "../lib/virtual/setup.js";

/**
 * @import { CameraKey } from "../sdk/calibdb.js"
 * @import { Calibration } from "../sdk/rectification.js"
 */

/**
 * @typedef {import("../vendor/api.js").Estimate & Calibration} Estimate
 *
 * @typedef {object} Known
 * @property {Calibration | null} calibration
 * @property {"returned" | "known" | "truth" | ""} origin measured just now, looked up, or what the virtual camera is
 *   made from
 * @property {string} guidance address where the camera can be calibrated, and that leads back here
 */

/**
 * @param {CameraKey} key of the camera that is open
 * @param {URLSearchParams} parameters of this page
 * @returns {Promise<Known>} rejects as `lookup` and `loadSettings` do
 */
export async function calibrationOf(key, parameters) {
  const guidance = guidanceFor(key, parameters);
  const brought = await result(key, parameters);
  if (brought) return { calibration: brought, origin: "returned", guidance };
  if (isVirtual(key.camera)) return { calibration: trueCalibration(setupFrom(parameters)), origin: "truth", guidance };
  const { calibration } = await lookup(key, { ...(await sdkOptions()), exact: true });
  return { calibration, origin: calibration ? "known" : "", guidance };
}

/**
 * Estimate of a camera without its calibrations.
 * @param {CameraKey} key @returns {Promise<Estimate>} rejects as `loadSettings` and the service do
 */
export async function estimateOf(key) {
  const body = { ...key, estimate: "always", miss: "ok" };
  return (await askJson("POST", "/lookup", { body, brief: true })).estimate;
}

/**
 * Calibration id that the capture page put into this page's address, which keeps it for a reload.
 * @param {CameraKey} key
 * @param {URLSearchParams} parameters
 */
async function result(key, parameters) {
  const asked = parameters.get("camera");
  if (!location.hash.includes("calibration=") || (asked !== null && asked !== key.camera)) return null;
  const kept = { state: null, replaceState() {} };
  const calibration = await returned({ ...(await sdkOptions()), history: kept }).catch(gone);
  const fits =
    calibration &&
    calibration.img_size.join() === key.img_size.join() &&
    isVirtual(calibration.camera) === isVirtual(key.camera);
  return fits ? calibration : null;
}

/** An old link: what it spoke of was withdrawn, or never was. @param {unknown} error */
function gone(error) {
  if (error instanceof LookupError && [404, 410].includes(error.status)) return null;
  throw error;
}

/**
 * The capture page for this camera; what made the virtual one goes with it, both ways.
 * @param {CameraKey} key @param {URLSearchParams} parameters
 */
function guidanceFor({ camera, platform, img_size, zoom }, parameters) {
  const back = new URLSearchParams(parameters);
  back.set("camera", camera);
  if (isVirtual(camera)) back.set("virtual", "1");
  const query = new URLSearchParams(back);
  for (const [name, value] of Object.entries({ platform, img_size: img_size.join("x"), zoom: zoom || "" }))
    if (value) query.set(name, String(value));
  query.set("return_to", new URL(`./?${back}`, location.href).href);
  return new URL(`../calibrate/?${query}`, location.href).href;
}
