// A stored calibration, with its report, and as a file in any format that the service writes.
import { ask, askJson } from "../api.js";
import { offerResponse } from "../files.js";
import { fileName } from "./numbers.js";

/** @import { Calibration, Report } from "./numbers.js" */

/**
 * @typedef {object} Facts what the service reports of a stored calibration besides its numbers
 * @property {import("../../vendor/api.js").Board | null} board
 * @property {string | null} cameraKey
 */

/** Facts of what was loaded, by id. @type {Map<string, Facts>} */
const facts = new Map();

/** @param {string | null} id @returns {Facts | null} null: not loaded */
export const factsOf = (id) => facts.get(id ?? "") ?? null;

/** Endings of file names, by type. @type {[type: RegExp, ending: string][]} */
const ENDINGS = [
  [/yaml/, "yaml"],
  [/xml/, "xml"],
  [/json/, "json"],
  [/text\/plain/, "txt"],
];

/** @param {number[]} without indices of views @returns {Record<string, string>} */
const withoutQuery = (without) => (without.length ? { without: without.join() } : {});

/** @param {string} id @param {Record<string, string>} [query] */
const path = (id, query = {}) =>
  `/calibrations/${encodeURIComponent(id)}${Object.keys(query).length ? `?${new URLSearchParams(query)}` : ""}`;

/**
 * @param {string} id @param {number[]} [without] indices of views: what it would be had they not been taken
 * @param {Partial<import("../api.js").Transport>} [transport]
 * @returns {Promise<{calibration: Calibration, report: Report | null}>} rejects as Api does: 422 where nothing is left
 *   to fit
 */
export async function load(id, without = [], transport = {}) {
  const {
    report = null,
    board = null,
    camera_key: cameraKey = null,
    ...calibration
  } = await askJson("GET", path(id, withoutQuery(without)), {}, transport);
  if (calibration.id) facts.set(calibration.id, { board, cameraKey });
  return { calibration, report };
}

/**
 * Agreed calibrations of a camera at one size, of all models.
 * @param {string} key
 * @param {readonly number[]} size px
 * @returns {Promise<Calibration[]>} rejects as Api does
 */
export async function knownCalibrations(key, size) {
  /** @type {{modes: {img_size: number[], consensus: Record<string, Calibration>}[]}} */
  const { modes } = await askJson("GET", `/cameras/${encodeURIComponent(key)}`);
  return modes
    .filter(({ img_size }) => img_size.join() === size.join())
    .flatMap(({ consensus }) => Object.values(consensus));
}

/**
 * @typedef {object} Saved
 * @property {string} name of the file
 * @property {number} error px; the most by which the file's projection of a ray is off the calibration's
 * @property {number} coverage share of the picture that the file describes, 0…1
 */

/**
 * Hands a file to the browser.
 * @param {Calibration} calibration
 * @param {string} format
 * @param {{id: string | null, without?: number[]}} [of] where it is stored, and which
 *   of its views are left out
 * @returns {Promise<Saved>} rejects as Api does: 422 where the format cannot hold the calibration
 */
export async function save(calibration, format, { id, without = [] } = calibration) {
  const response = await ask("GET", path(id ?? "", { format, ...withoutQuery(without) }), {
    accept: "*/*",
  });
  const { headers } = response;
  return {
    name: await offerResponse(response, fileName(calibration, endingOf(headers.get("content-type") ?? ""))),
    error: measure(headers.get("x-conversion-error"), 0),
    coverage: measure(headers.get("x-conversion-coverage"), 1),
  };
}

/** @param {string | null} header @param {number} otherwise where the service says nothing */
function measure(header, otherwise) {
  const value = Number(header ?? otherwise);
  return Number.isFinite(value) ? value : otherwise;
}

/** @param {string} type */
const endingOf = (type) => ENDINGS.find(([kind]) => kind.test(type))?.[1] ?? "bin";
