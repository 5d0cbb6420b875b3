// Calibrations that were made in this browser: kept here, so that their maker finds them again. Nothing is sent.
import { levelOf } from "./result/numbers.js";
import { keepItem, readJson } from "./storage.js";

/** @import { Calibration, Report } from "./result/numbers.js" */

const KEY = "calibdb.own";
const MAX_OWN = 100; // calibrations; the oldest go first

/**
 * @typedef {object} Own
 * @property {string} id
 * @property {string} camera its label
 * @property {[number, number]} img_size px
 * @property {number} time unix seconds
 * @property {"good" | "fair" | "poor"} level
 * @property {number} rms typical error, px
 */

/**
 * @param {Calibration & {id: string}} calibration
 * @param {Report | null} report
 * @returns {Own}
 */
export function ownOf(calibration, report) {
  const { id, camera, img_size, calibration_time: time, uncertainty } = calibration;
  return { id, camera, img_size, time, level: report?.verdict.level ?? levelOf(calibration), rms: uncertainty.rms };
}

/** The newest first. @returns {Own[]} */
export function ownCalibrations() {
  const kept = readJson(KEY);
  return Array.isArray(kept)
    ? kept.filter(
        (each) => typeof each?.id === "string" && typeof each.camera === "string" && Array.isArray(each.img_size),
      )
    : [];
}

/** @param {Own} own @returns {boolean} whether it is kept */
export function keepOwn(own) {
  return write([own, ...ownCalibrations().filter(({ id }) => id !== own.id)].slice(0, MAX_OWN));
}

/** @param {string} [id] all of them without one */
export function forgetOwn(id) {
  write(id === undefined ? [] : ownCalibrations().filter((each) => each.id !== id));
}

/** @param {Own[]} all */
const write = (all) => keepItem(KEY, all.length ? JSON.stringify(all) : null);
