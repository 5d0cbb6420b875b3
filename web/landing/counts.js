// Counts of the database: how many cameras and calibrations it has.
import { askJson } from "../lib/api.js";

const LIMIT = 50; // cameras of one answer

/**
 * @typedef {{cameras: number, ready: number, calibrations: number, more: boolean}} Counts ready: cameras that a lookup
 *   answers
 */

/** @returns {Promise<Counts>} of the first cameras of the list; `more`: there are others */
export async function countCameras() {
  const { cameras, next } = await askJson("GET", `/cameras?limit=${LIMIT}`);
  return countsOf(cameras, next !== null);
}

/** @param {{sizes: {reliable: boolean, calibrations: number}[]}[]} cameras @param {boolean} more @returns {Counts} */
export function countsOf(cameras, more) {
  return {
    cameras: cameras.length,
    ready: cameras.filter(({ sizes }) => sizes.some(({ reliable }) => reliable)).length,
    calibrations: cameras.reduce(
      (sum, { sizes }) => sizes.reduce((own, { calibrations }) => own + calibrations, sum),
      0,
    ),
    more,
  };
}
