// Pause between attempts to reach the service: it ends early when the browser has a network again, or when the page
// knows that the service is back.

const RECONNECT_S = [1, 2, 3, 4, 5]; // after so many failures; the last one again and again

/** Pause before another attempt, ms. @param {number} failures so far, 0 for the first */
export const reconnectPause = (failures) => 1000 * RECONNECT_S[Math.min(failures, RECONNECT_S.length - 1)];

export class Pause {
  #end = () => {};

  /** @param {number} ms @returns {Promise<void>} */
  wait(ms) {
    return new Promise((resolve) => {
      const over = new AbortController();
      this.#end = () => {
        clearTimeout(timer);
        over.abort();
        resolve();
      };
      const timer = setTimeout(this.#end, ms);
      globalThis.addEventListener?.("online", this.#end, { signal: over.signal });
    });
  }

  /** Ends the pause, if there is one. */
  end() {
    this.#end();
  }
}
