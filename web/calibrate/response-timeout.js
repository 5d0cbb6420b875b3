// ResponseTimeout with a service that says nothing: renewed by each answer and by each new question, and then at an end.

export class ResponseTimeout {
  #ms;
  #onEnd;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  #timer;
  /** Is it at an end? */
  lost = false;
  #ended = false;

  /** @param {number} ms @param {() => void} onEnd */
  constructor(ms, onEnd) {
    this.#ms = ms;
    this.#onEnd = onEnd;
    this.renew();
  }

  /** @param {number} [ms] for what is asked now */
  renew(ms = this.#ms) {
    if (this.lost || this.#ended) return;
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => {
      this.lost = true;
      this.#onEnd();
    }, ms);
  }

  /** There is nothing more to wait for. */
  end() {
    this.#ended = true;
    clearTimeout(this.#timer);
  }
}
