// Receipts of the calibrations made with this browser, kept in it and nowhere else. Who shows one to the operator has
// made that calibration, and can have it erased (`/privacy/`).
import { keepItem, readJson } from "./storage.js";

/**
 * @typedef {object} Receipt
 * @property {string} id of the calibration
 * @property {string} camera its label
 * @property {number} time ms since 1970
 * @property {string} receipt the session id: signed by the service, and of no other use after half an hour
 */

const RECEIPTS_KEY = "calibdb.receipts";
const MAX_RECEIPTS = 50;
const MAX_AGE_MS = 365 * 24 * 3600 * 1000;

/** Those of the last year, newest first. @returns {Receipt[]} */
export function receipts(now = Date.now()) {
  const kept = readJson(RECEIPTS_KEY);
  return Array.isArray(kept) ? kept.filter(({ time }) => now - time < MAX_AGE_MS) : [];
}

/**
 * Keeps the receipt of a session that has ended.
 * @param {string} receipt
 * @param {{calibration_id?: string | null, camera?: string}} state
 */
export function keepReceipt(receipt, { calibration_id: id, camera = "" }, now = Date.now()) {
  if (!id || !receipt) return;
  const others = receipts(now).filter((each) => each.id !== id);
  keepItem(RECEIPTS_KEY, JSON.stringify([{ id, camera, time: now, receipt }, ...others].slice(0, MAX_RECEIPTS)));
}

/** Forgets all of them. The calibrations stay where they are. */
export function removeReceipts() {
  keepItem(RECEIPTS_KEY, null);
}
