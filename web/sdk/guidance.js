// Navigation to the guidance page, and return with its result.
import { Calibration } from "./calibration.js";
import { keyOf } from "./key.js";
import { guidanceUrl } from "./lookup.js";
import { ask, calibrationIn } from "./request.js";

/** Permanent failures: they also remove the result from the address. */
const GONE_STATUSES = [404, 410];

/**
 * @typedef {import("./calibration.js").CalibrationData} CalibrationData
 *
 * @typedef {object} Journey
 * @property {string | URL} [returnTo] address to come back to; that of this page by default
 * @property {MediaStreamTrack | import("./key.js").CameraKey} [source] the camera; by default, the one chosen there
 * @property {string} [guidanceUrl] of a lookup's answer
 * @property {string} [model] distortion model, "rectilinear" by default
 * @property {{href: string, assign: (address: string) => void}} [location]
 * @property {{state: any, replaceState: (state: any, unused: string, address: string) => void}} [history]
 *
 * @typedef {Journey & import("./request.js").RequestOptions} JourneyOptions
 */

/**
 * Navigates to the guidance page, and returns the result once this page is loaded again: call it in both cases.
 * The way back is a link on the result, to any HTTPS address and to addresses of the visitor's own machine.
 * @param {JourneyOptions} options
 * @returns {Promise<Calibration>} of one capture, not of a consensus; does not settle while the page is left
 */
export async function calibrate(options) {
  const result = await returned(options);
  if (result) return result;
  const { source, model = "rectilinear", api, location = globalThis.location } = options;
  const key = source ? await keyOf(source) : null;
  options.signal?.throwIfAborted();
  const url = new URL(options.guidanceUrl ?? guidanceUrl(key, model, api));
  url.searchParams.set("return_to", new URL(options.returnTo ?? location.href, location.href).href);
  location.assign(url.href);
  return new Promise(() => {});
}

/**
 * The result that the guidance page put into the address, if any. It is then removed from the address.
 * @param {JourneyOptions} options
 * @returns {Promise<Calibration | null>} rejects as `lookup` does
 */
export async function returned({ location = globalThis.location, history = globalThis.history, ...manner }) {
  const url = new URL(location.href);
  const fragment = new URLSearchParams(url.hash.slice(1));
  const id = fragment.get("calibration");
  if (!id) return null;
  const answer = await ask(`calibrations/${encodeURIComponent(id)}`, {}, manner);
  if (answer.response.ok || GONE_STATUSES.includes(answer.response.status)) {
    fragment.delete("calibration");
    url.hash = fragment.toString();
    history.replaceState(history.state, "", url.href);
  }
  const { report: _, ...data } = /** @type {CalibrationData & {report?: object}} */ (calibrationIn(answer));
  return new Calibration(data);
}
