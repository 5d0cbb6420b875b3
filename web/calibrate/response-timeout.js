// Timeout for responses of the service: restarted by each request and each response.

export class ResponseTimeout {
  #ms;
  #onExpire;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #timer;
  /** True if the time is over. */
  expired = false;
  #cancelled = false;

  /** @param {number} ms @param {() => void} onExpire */
  constructor(ms, onExpire) {
    this.#ms = ms;
    this.#onExpire = onExpire;
    this.restart();
  }

  /** @param {number} [ms] for the request that is sent now */
  restart(ms = this.#ms) {
    if (this.expired || this.#cancelled) return;
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => {
      this.expired = true;
      this.#onExpire();
    }, ms);
  }

  /** Stops waiting. */
  cancel() {
    this.#cancelled = true;
    clearTimeout(this.#timer);
  }
}
