// Objects stored next to the weekly dump: statistics of the database, and the names of the dump's files.
import { OfflineError, reach, readable } from "./network.js";

/**
 * @typedef {object} Snapshot the database on one day
 * @property {string} date YYYY-MM-DD
 * @property {number} cameras
 * @property {number} known
 * @property {number} calibrations
 * @property {number} contributors
 */

/** Folder of the dumps. */
export const DUMPS = new URL("../dumps/", import.meta.url);

/** @template T @param {string} name @returns {Promise<T | null>} null: there is none yet, or no network */
export async function fetchObject(name) {
  try {
    const response = await reach(new URL(name, DUMPS));
    return response.ok ? await readable(response.json()) : null;
  } catch (error) {
    if (!(error instanceof OfflineError)) throw error;
    return null;
  }
}

/** The database's newest figures. @returns {Promise<Snapshot | null>} null: not counted yet, or no network */
export async function newestFigures() {
  /** @type {{history: Snapshot[]} | null} */
  const statistics = await fetchObject("statistics.json");
  return statistics?.history.at(-1) ?? null;
}
