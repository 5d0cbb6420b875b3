// Requests for cameras of the database.
import { askJson } from "../lib/api.js";

/** @import { Member } from "./agreement.js" */

/**
 * @typedef {import("../sdk/calibdb.js").CalibrationData} Calibration
 *
 * @typedef {object} Size
 * @property {[number, number]} img_size
 * @property {number} zoom
 * @property {string[]} models
 * @property {number} calibrations
 * @property {number} contributors
 * @property {number} agreeing
 * @property {number} required
 * @property {boolean} reliable
 * @property {number | null} fx px
 * @property {number | null} uncertainty px
 * @property {number | null} calibration_time unix seconds
 *
 * @typedef {object} Found
 * @property {string} key
 * @property {string} camera
 * @property {string} platform
 * @property {string | null} usb_id
 * @property {string | null} vendor
 * @property {Size[]} sizes
 *
 * @typedef {object} Mode one size and zoom
 * @property {[number, number]} img_size
 * @property {number} zoom
 * @property {number} calibrations
 * @property {number} contributors
 * @property {number} agreeing
 * @property {number} required
 * @property {string | null} [reason] why it is not reliable
 * @property {string[][]} groups
 * @property {(string | null)[]} [group_names] that contributors gave
 * @property {Record<string, Calibration>} consensus by model
 * @property {Member[]} members
 *
 * @typedef {{key: string, camera: string, platform: string, usb_id: string | null, vendor: string | null, modes:
 *   Mode[]}} CameraPage
 */

/** @typedef {import("../lib/api.js").Transport["onRetry"]} OnRetry */

/**
 * @param {string} query @param {"" | "ready" | "open"} state cameras that a lookup answers, the others, or all
 * @param {string | null} next where the last page of answers ended @param {OnRetry} onRetry
 * @returns {Promise<{cameras: Found[], next: string | null}>}
 */
export function search(query, state, next, onRetry) {
  const parameters = new URLSearchParams({
    query,
    limit: "20",
    ...(state ? { reliable: String(state === "ready") } : {}),
    ...(next ? { after: next } : {}),
  });
  return askJson("GET", `/cameras?${parameters}`, {}, { onRetry });
}

/** @param {string} key @param {OnRetry} onRetry @returns {Promise<CameraPage>} */
export function camera(key, onRetry) {
  return askJson("GET", `/cameras/${encodeURIComponent(key)}`, {}, { onRetry });
}

/**
 * The consensus of one mode for another model: the first request computes it.
 * @param {CameraPage} page @param {Mode} mode @param {string} model
 * @returns {Promise<Calibration>}
 */
export function withModel({ camera, platform }, { img_size, zoom }, model) {
  return askJson("POST", "/lookup", {
    body: { camera, platform, img_size, zoom, distortion_model: model, redirect: false },
  });
}

/**
 * The estimate of a camera that is not reliably known at a size; null where a lookup answers with a calibration.
 * @param {CameraPage} page @param {Pick<Mode, "img_size" | "zoom">} mode
 * @returns {Promise<import("../sdk/calibration.js").EstimateData | null>}
 */
export async function estimateOf({ camera, platform }, { img_size, zoom }) {
  const { estimate = null } = await askJson("POST", "/lookup", {
    body: { camera, platform, img_size, zoom, redirect: false, miss: "ok" },
  });
  return estimate;
}
