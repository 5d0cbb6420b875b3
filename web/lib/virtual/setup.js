// Setup of the virtual camera as an address asks for it, and its label. Apart from the camera: few pages need more.
import { NAME } from "../camera-name.js";

/** @import { LensParameters } from "./lens.js" */

const [MIN_RATE_HZ, USUAL_RATE_HZ, MAX_RATE_HZ] = [2, 30, 60]; // pictures a second

/**
 * @typedef {object} Setup
 * @property {[number, number]} size px
 * @property {LensParameters} lens
 * @property {number} error how clumsy the hand is: 0 not at all, 1 about 3° and 3 % of the distance
 * @property {number} seed of the hand
 * @property {string} hand whose it is, of `HANDS`; of any other name: a still one
 * @property {number} rate pictures a second
 * @property {string} fault what is wrong with the picture, of `FAULTS`; any other name is nothing
 * @property {{legacy?: boolean, dictionary?: string, distance?: number}} shown how the board differs from the one
 *   asked for; distance: how many times as far away as asked for
 */

/**
 * The camera that an address asks for: `img_size=1280x720`, `fx fy cx cy` in px, `k1 k2 p1 p2 k3`; the hand, `error
 * seed hand`; pictures a second, `rate`; what is wrong, `fault shown_legacy shown_dictionary shown_distance`.
 * @param {URLSearchParams} parameters
 * @returns {Setup}
 */
export function setupFrom(parameters) {
  const [, w, h] = /^(\d{2,4})x(\d{2,4})$/.exec(parameters.get("img_size") ?? "") ?? ["", "1280", "720"];
  const [width, height] = [Number(w), Number(h)];
  /** @param {string} name @param {number} otherwise */
  const number = (name, otherwise) => {
    const text = parameters.get(name);
    const value = Number(text);
    return text && Number.isFinite(value) ? value : otherwise;
  };
  const fx = number("fx", 0.8 * width);
  return {
    size: [width, height],
    lens: {
      fx,
      fy: number("fy", fx),
      cx: number("cx", (width - 1) / 2 + 0.012 * width),
      cy: number("cy", (height - 1) / 2 - 0.012 * width),
      k1: number("k1", -0.2),
      k2: number("k2", 0.04),
      p1: number("p1", 0),
      p2: number("p2", 0),
      k3: number("k3", 0),
    },
    error: number("error", 1),
    seed: number("seed", 1),
    hand: parameters.get("hand") ?? "still",
    rate: Math.min(MAX_RATE_HZ, Math.max(MIN_RATE_HZ, number("rate", USUAL_RATE_HZ))),
    fault: parameters.get("fault") ?? "",
    shown: {
      ...(parameters.has("shown_legacy") && { legacy: parameters.get("shown_legacy") === "true" }),
      ...(parameters.has("shown_dictionary") && { dictionary: parameters.get("shown_dictionary") ?? "" }),
      distance: number("shown_distance", 1),
    },
  };
}

/** The name it reports: another lens is another camera. @param {Setup} setup */
export function labelOf({ size, lens }) {
  const text = JSON.stringify([size, ...Object.entries(lens).flat()]);
  let hash = 0x811c9dc5; // FNV-1a
  for (const character of text) hash = Math.imul(hash ^ character.charCodeAt(0), 0x01000193) >>> 0;
  return `${NAME} ${hash.toString(16).padStart(8, "0")}`;
}
