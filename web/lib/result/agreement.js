// Agreement of a calibration's camera: how many calibrations of it agree, and how many must.
import { askJson } from "../api.js";

/**
 * @typedef {object} Agreement
 * @property {string} key of the camera
 * @property {number} agreeing
 * @property {number} required
 * @property {boolean} reliable a lookup answers with it
 * @property {boolean} settled the consensus has this calibration in its count
 */

const WAITS_MS = [1500, 3000, 6000]; // ms; a consensus is computed seconds after a capture

/**
 * @param {string} key of the camera @param {{id: string | null, img_size: readonly number[], zoom: number}} calibration
 * @param {AbortSignal} signal
 * @param {(agreement: Agreement) => void} onAgreement called with what is known, and again with what a new consensus
 *   says
 * @param {(ms: number) => Promise<void>} [wait]
 */
export async function followAgreement(
  key,
  calibration,
  signal,
  onAgreement,
  wait = (ms) => new Promise((done) => setTimeout(done, ms)),
) {
  for (const pause of [...WAITS_MS, null]) {
    const page = await askJson("GET", `/cameras/${encodeURIComponent(key)}`, { brief: true }, { signal });
    if (signal.aborted) return;
    const agreement = agreementOf(key, page, calibration);
    onAgreement(agreement);
    if (agreement.settled || pause === null) return;
    await wait(pause);
    if (signal.aborted) return;
  }
}

/**
 * @param {string} key @param {{modes: import("../../vendor/api.js").CameraDetail["modes"]}} page
 * @param {{id: string | null, img_size: readonly number[], zoom: number}} calibration
 * @returns {Agreement}
 */
export function agreementOf(key, { modes }, { id, img_size, zoom }) {
  const mode = modes.find((each) => each.img_size.join() === img_size.join() && each.zoom === zoom);
  const counted = (mode?.groups ?? []).some((group) => group.includes(id ?? ""));
  const listed = mode?.members.some((member) => member.id === id) ?? false;
  return {
    key,
    required: mode?.required ?? 5,
    reliable: mode !== undefined && mode.reason === null,
    // It agrees with itself before any consensus says so.
    agreeing: Math.max(mode?.agreeing ?? 0, 1),
    settled: counted || (mode !== undefined && !listed) || (id ?? "").includes("~"),
  };
}
