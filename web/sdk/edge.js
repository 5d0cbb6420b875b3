// Known cameras: a lookup without a credential. Caches near the caller answer it, even for a day without a server.
import { CROPPED } from "./key.js";
import { address, reach } from "./request.js";

/**
 * @typedef {import("./key.js").CameraKey} CameraKey
 * @typedef {import("./calibration.js").CalibrationData} CalibrationData
 * @typedef {import("./request.js").RequestOptions} RequestOptions
 *
 * @typedef {"answered" | "missing" | "unasked"} Outcome missing: the edge is there and has no answer; unasked: it is
 *   not there
 * @typedef {{outcome: Outcome, calibration: CalibrationData | null}} EdgeAnswer
 */

const FOLDER = "../known/v1/"; // next to the API

/**
 * Address of a lookup: half of a SHA-256, so that it contains no label. See docs/api.md.
 * @param {CameraKey} key @param {string} model @param {string | URL} [api]
 * @returns {Promise<URL | null>} null where there is none
 */
export async function edgeAddress({ camera, platform, img_size: size, zoom, resize_mode: mode }, model, api) {
  const digits = zoomText(zoom);
  // Without a secure context there is no digest; there are no cameras either.
  if (mode === CROPPED || digits === null || !globalThis.crypto?.subtle) return null;
  const text = ["v1", camera.normalize("NFC").trim(), platform].join("\n");
  const hash = await crypto.subtle.digest("SHA-256", new TextEncoder().encode(text));
  const digest = Array.from(new Uint8Array(hash, 0, 16), (byte) => byte.toString(16).padStart(2, "0")).join("");
  return new URL(`${FOLDER}${digest}/${size.join("x")}/${digits}/${model}.json`, address(api));
}

/**
 * Asks the edge, once. If the edge does not know a camera, the caller asks the service.
 * @param {CameraKey} key @param {string} model @param {RequestOptions} options
 * @returns {Promise<EdgeAnswer>} rejects as its signal says
 */
export async function askEdge(key, model, { api, signal, fetch = globalThis.fetch }) {
  const url = await edgeAddress(key, model, api);
  signal?.throwIfAborted();
  if (!url?.protocol.startsWith("http")) return { outcome: "unasked", calibration: null };
  // Without custom headers, which would need a preflight, and without cookies.
  const answer = await reach(fetch, url, { credentials: "omit", signal });
  if (!("response" in answer)) return { outcome: "unasked", calibration: null };
  const {
    response: { ok, status },
    body,
  } = answer;
  if (ok && body.camera_matrix) return { outcome: "answered", calibration: body };
  return { outcome: status === 404 ? "missing" : "unasked", calibration: null };
}

/**
 * As the service writes it: to six decimals, without zeros at the end.
 * @param {number} zoom
 * @returns {string | null} null: it has more
 */
function zoomText(zoom) {
  const text = zoom.toFixed(6);
  return Number(text) === zoom ? text.replace(/\.?0+$/, "") : null;
}
