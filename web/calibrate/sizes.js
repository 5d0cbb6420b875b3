// The size of the picture to ask the camera for. What it then gives is what is calibrated.
import { t } from "../lib/i18n.js";

/** @typedef {[number, number]} Size px */

/** More than any camera has: the nearest to it is the camera's own largest. */
const MAX_SIZE = /** @type {Size} */ ([15360, 8640]);
const OFFERED = /** @type {Size[]} */ ([
  [1280, 720],
  [1920, 1080],
  [640, 480],
]);

export class Sizes {
  static USUAL = /** @type {Size} */ ([1280, 720]);
  #select;
  #offered;

  /** @param {HTMLSelectElement} select @param {Size} asked what the page was opened for */
  constructor(select, asked) {
    this.#select = select;
    const others = OFFERED.filter((size) => String(size) !== String(asked));
    this.#offered = [asked, ...others, MAX_SIZE];
    this.write();
  }

  /** @returns {Size} */
  get chosen() {
    return this.#offered[Math.max(0, this.#select.selectedIndex)];
  }

  /** In the visitor's language. */
  write() {
    const { selectedIndex } = this.#select;
    this.#select.replaceChildren(
      ...this.#offered.map((size) => new Option(size === MAX_SIZE ? t("capture.largest") : size.join(" × "))),
    );
    this.#select.selectedIndex = Math.max(0, selectedIndex);
  }
}
