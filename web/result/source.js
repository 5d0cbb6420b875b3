// A stored calibration, with its report, and as a file in any format that the service writes.
import { Api } from "../calibrate/api.js";
import { loadSettings } from "../settings.js";
import { fileName } from "./numbers.js";

/**
 * @typedef {import("./numbers.js").Calibration} Calibration
 * @typedef {import("./numbers.js").Report} Report
 */

/** What files end with, by what they are. @type {[type: RegExp, ending: string][]} */
const ENDINGS = [[/yaml/, "yaml"], [/xml/, "xml"], [/json/, "json"], [/text\/plain/, "txt"]];

/** @param {string} id @param {Record<string, string>} [query] */
const path = (id, query = {}) => `/calibrations/${encodeURIComponent(id)}${Object.keys(query).length ? `?${new URLSearchParams(query)}` : ""}`;

/** @param {string} id @returns {Promise<{calibration: Calibration, report: Report | null}>} rejects as Api does */
export async function load(id) {
  const { api, token } = await loadSettings();
  const { report = null, ...calibration } = await new Api(api).json("GET", path(id), token);
  return { calibration, report };
}

/** Hands a file to the browser. @param {Calibration} calibration @param {string} format */
export async function save(calibration, format) {
  const { api, token } = await loadSettings();
  const response = await new Api(api).send("GET", path(calibration.id ?? "", { format }), token, { accept: "*/*" });
  const type = response.headers.get("content-type") ?? "";
  const ending = ENDINGS.find(([kind]) => kind.test(type))?.[1] ?? "bin";
  const [, named] = /filename="?([^";]+)"?/.exec(response.headers.get("content-disposition") ?? "") ?? [];
  const link = document.createElement("a");
  link.href = URL.createObjectURL(await response.blob());
  link.download = named ?? (format === "calibdb" ? fileName(calibration) : fileName(calibration, `${format}.${ending}`));
  link.click();
  // The browser has taken it by the time it takes anything else.
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}
