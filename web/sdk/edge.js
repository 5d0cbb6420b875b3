// Answers at the edge: cameras that are known are answered by files, which are cached near the caller and stay there while no server runs.
import { CROPPED } from "./key.js";
import { address, reach } from "./request.js";

/**
 * @typedef {import("./key.js").CameraKey} CameraKey
 * @typedef {import("./calibration.js").CalibrationData} CalibrationData
 * @typedef {import("./request.js").RequestOptions} RequestOptions
 *
 * @typedef {"answered" | "missing" | "unasked"} Outcome missing: the edge is there and has no answer; unasked: it is not there
 * @typedef {{outcome: Outcome, calibration: CalibrationData | null}} EdgeAnswer
 */

const FOLDER = "../known/"; // beside the API
const CONFIG = "../config.json";

/**
 * Addresses of APIs whose deployment wants every lookup to be counted.
 * @type {Map<string, boolean>}
 */
const off = new Map();

/**
 * Address of the file that answers a lookup: half of a SHA-256, so that no label stands in it. See docs/api.md.
 * @param {CameraKey} key @param {string} model @param {string | URL} [api]
 * @returns {Promise<URL | null>} null where no file can answer
 */
export async function edgeAddress({ camera, platform, img_size: size, zoom, resize_mode: mode }, model, api) {
  const digits = zoomText(zoom);
  // Without a secure context there is no digest; there are no cameras either.
  if (mode === CROPPED || digits === null || !globalThis.crypto?.subtle) return null;
  const text = ["v1", camera.normalize("NFC").trim(), platform, size.join("x"), digits, model].join("\n");
  const hash = await crypto.subtle.digest("SHA-256", new TextEncoder().encode(text));
  const digest = Array.from(new Uint8Array(hash, 0, 16), (byte) => byte.toString(16).padStart(2, "0")).join("");
  return new URL(`${FOLDER}${digest.slice(0, 2)}/${digest}.json`, address(api));
}

/**
 * Asks the edge, once: whatever is not there is asked of the service.
 * @param {CameraKey} key @param {string} model @param {RequestOptions} options
 * @returns {Promise<EdgeAnswer>} rejects as its signal says
 */
export async function askEdge(key, model, { api, signal, fetch = globalThis.fetch }) {
  const url = off.get(address(api).href) ? null : await edgeAddress(key, model, api);
  signal?.throwIfAborted();
  if (!url?.protocol.startsWith("http")) return { outcome: "unasked", calibration: null };
  // Without headers of its own, which a browser would have to ask permission for first, and without cookies.
  const answer = await reach(fetch, url, { credentials: "omit", signal });
  if (!("response" in answer)) return { outcome: "unasked", calibration: null };
  const { response: { ok, status }, body } = answer;
  if (ok && body.camera_matrix) return { outcome: "answered", calibration: body };
  return { outcome: status < 500 ? "missing" : "unasked", calibration: null };
}

/**
 * Finds out whether the deployment answers at the edge at all, for the lookups after this one.
 * @param {RequestOptions} options
 */
export async function readEdgeSwitch({ api, signal, fetch = globalThis.fetch }) {
  const { href } = address(api);
  if (off.has(href)) return;
  off.set(href, false);
  const answer = await reach(fetch, new URL(CONFIG, href), { credentials: "omit", signal }).catch(() => null);
  if (answer === null) off.delete(href); // given up before it was answered
  else if ("response" in answer && answer.response.ok) off.set(href, answer.body.edge_answers === "off");
}

/** As the service writes it: to six decimals, without zeros at the end. @param {number} zoom @returns {string | null} null: it has more */
function zoomText(zoom) {
  const text = zoom.toFixed(6);
  return Number(text) === zoom ? text.replace(/\.?0+$/, "") : null;
}
