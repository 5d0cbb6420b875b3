// Board detector of a page: OpenCV is loaded once for several captures.

/** @typedef {import("../detector.js").Detector} Detector */

export class PageDetector {
  #make;
  /** @type {Promise<Detector> | null} */
  #last = null;

  /** @param {() => Promise<Detector>} make */
  constructor(make) {
    this.#make = make;
  }

  /** The detector; another one if the last has failed or was closed. @returns {Promise<Detector>} */
  open() {
    const opening = this.#reopen(this.#last);
    this.#last = opening;
    opening.catch(() => {
      if (this.#last === opening) this.#last = null;
    });
    return opening;
  }

  /** @param {Promise<Detector> | null} last */
  async #reopen(last) {
    const detector = await last?.catch(() => null);
    return detector && !detector.closed ? detector : this.#make();
  }

  /** Closes the detector, as after a failure or for another board: the next capture makes a new one. */
  close() {
    void this.#last?.then(
      (detector) => detector.close(),
      () => {},
    );
    this.#last = null;
  }
}
