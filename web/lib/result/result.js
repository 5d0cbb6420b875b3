// A result as a page shows it: types alone.

/**
 * @typedef {import("./numbers.js").Calibration} Calibration
 * @typedef {import("./numbers.js").Report} Report
 *
 * @typedef {object} Result
 * @property {Calibration} calibration
 * @property {Report | null} report null: not there, or not yet
 * @property {HTMLCanvasElement | null} [picture] one of this camera, which stays on this device
 * @property {"added" | "imported" | "practice" | "stored"} origin what becomes of it
 * @property {boolean} [ownCameraOffered] the page itself offers to calibrate a real camera after practice
 * @property {string | null} [returnTo] address of the application that asked
 * @property {readonly string[]} [returnOrigins] to which results may be handed
 * @property {boolean} [pending] the report is on its way
 * @property {{code: string, text: string}[]} [notes] what else is to be said
 * @property {{label: () => string, action: () => void}} [again]
 * @property {(without: number[]) => void} [goOn] with the views that are left, by whom they were taken; indices
 * @property {(index: number) => string} [names] of the photographs that views come from, "" where there is none
 * @property {(index: number) => string | null} [photo] address of the picture that a view comes from, which stays on
 *   this device
 * @property {(() => void) | null} [turnOff] ends the picture, which is that of the open camera
 * @property {HTMLElement} [aside] what the page adds below the card: consent, or advice
 * @property {(error: unknown) => string} explain an error, in words for people
 */

export {};
