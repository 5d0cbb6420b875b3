// Conversion of a file by the service: the readers of other programs' files are there, and nothing is stored.
import { ask, askJson } from "./api.js";
import { offerResponse } from "./files.js";

/** @import { Calibration } from "./result/numbers.js" */

/**
 * @typedef {object} Source what is sent of a file
 * @property {string} file its text, or base64
 * @property {"text" | "base64"} encoding
 *
 * @typedef {object} Camera as the service reads it
 * @property {string} camera its name; "camera" where the file has none
 * @property {[number, number]} img_size
 * @property {number[][]} camera_matrix
 * @property {number[]} distortion_coefficients
 * @property {string} distortion_model
 *
 * @typedef {{img_size?: [number, number], camera?: string}} Hints what the file does not say
 */

export const MAX_CHARACTERS = 100_000; // that the service takes
const PACKED = /'optimization_inputs'\s*:\s*b'[^']*'\s*,?/; // mrcal's measurements, which no camera needs
const ARCHIVE = [0x50, 0x4b, 3, 4]; // first bytes of a .npz

/**
 * Part of a file that is sent.
 * @param {ArrayBuffer} bytes @param {string} text of it
 * @returns {Source | null} null: it is too large for a camera
 */
export function sourceOf(bytes, text) {
  const head = new Uint8Array(bytes, 0, Math.min(4, bytes.byteLength));
  const isArchive = ARCHIVE.every((byte, index) => head[index] === byte);
  const file = isArchive ? base64(bytes) : text.replace(PACKED, "");
  return file.length > 0 && file.length <= MAX_CHARACTERS ? { file, encoding: isArchive ? "base64" : "text" } : null;
}

/** @param {ArrayBuffer} bytes */
function base64(bytes) {
  if (bytes.byteLength > MAX_CHARACTERS) return " ".repeat(MAX_CHARACTERS + 1);
  return btoa(Array.from(new Uint8Array(bytes), (byte) => String.fromCharCode(byte)).join(""));
}

/**
 * The camera in a file.
 * @param {Source} source @param {Hints} hints
 * @returns {Promise<Camera>} rejects as Api does: 422 where none is read
 */
export async function readCamera(source, hints) {
  return askJson("POST", "/convert", { body: { ...source, ...hints } });
}

/**
 * Hands the file to the browser in another format.
 * @param {Source} source @param {Hints} hints @param {string} format @param {Camera} camera
 * @returns {Promise<import("./result/source.js").Saved>} rejects as Api does: 422 where the format cannot hold the
 *   camera
 */
export async function saveAs(source, hints, format, camera) {
  const response = await ask("POST", "/convert", {
    body: { ...source, ...hints, format },
    accept: "*/*",
  });
  const number = (/** @type {string} */ header, /** @type {number} */ otherwise) =>
    Number(response.headers.get(header) ?? otherwise);
  const name = await offerResponse(response, `${camera.camera}.txt`);
  return { name, error: number("x-conversion-error", 0), coverage: number("x-conversion-coverage", 1) };
}

/**
 * The corners that mrcal packs into its files, as a PhotonVision file.
 * @param {string} file @returns {Promise<string>} rejects as Api does: 422 where there are none
 */
export async function unpackCorners(file) {
  const response = await ask("POST", "/convert", {
    body: { file, format: "photonvision" },
    accept: "*/*",
  });
  return response.text();
}

/**
 * Cameras of the database by name.
 * @param {string} query
 * @returns {Promise<{key: string, camera: string, platform: string}[]>} rejects as Api does
 */
export async function searchCameras(query) {
  const { cameras } = await askJson("GET", `/cameras?${new URLSearchParams({ query, limit: "20" })}`);
  return cameras;
}
