// Outbox of a rig's client: what it has captured and the service does not have yet, in order. Nothing leaves it
// unanswered.
import { ApiError } from "../lib/api.js";
import { Pause, reconnectPause } from "../lib/capture/pause.js";
import { isUnavailable } from "../lib/session.js";

/**
 * @typedef {{kind: "open", moment: string}} Opening of a moment, by the leader
 * @typedef {{kind: "undo", moment: string}} Undoing
 * @typedef {{kind: "view", position: number, session: string, moment: string, ids: number[], points: number[][]}}
 *   TakenView
 * @typedef {Opening | Undoing | TakenView} Letter
 *
 * @typedef {object} Options
 * @property {(letter: Letter) => Promise<unknown>} send
 * @property {() => void} save called after each change
 * @property {(letter: Letter, answer: any) => void} onSent
 * @property {(letter: Letter, error: ApiError) => void} onRefused the service does not want it
 * @property {(offline: boolean) => void} onLink called when the service is away, and when it is back
 * @property {AbortSignal} [signal] after which nothing more is sent
 */

export class Outbox {
  /** @type {Letter[]} */
  #letters;
  #options;
  /** @type {Promise<void> | null} */
  #running = null;
  #pause = new Pause();

  /** @param {Options} options @param {readonly Letter[]} [letters] of an earlier page */
  constructor(options, letters = []) {
    this.#options = options;
    this.#letters = [...letters];
  }

  /** Letters that wait. @returns {readonly Letter[]} */
  get letters() {
    return this.#letters;
  }

  /** Number of views that wait. */
  get views() {
    return this.#letters.filter(({ kind }) => kind === "view").length;
  }

  /** @param {...Letter} letters */
  post(...letters) {
    this.#letters.push(...letters);
    this.#options.save();
    void this.flush();
  }

  /**
   * Drops what waits of a moment.
   * @param {string} moment
   * @returns {boolean} whether its opening was among it: the service never heard of it
   */
  withdraw(moment) {
    // The first one may be on its way.
    const unopened = this.#letters.some(
      (letter, index) => letter.kind === "open" && letter.moment === moment && (index > 0 || !this.#running),
    );
    this.#letters = this.#letters.filter((letter) => letter.moment !== moment);
    this.#options.save();
    return unopened;
  }

  /**
   * Sends the waiting letters, and retries until it succeeds.
   * @returns {Promise<void>} resolves when nothing waits, or nothing more is to be sent
   */
  flush() {
    this.#running ??= this.#run().finally(() => {
      this.#running = null;
    });
    return this.#running;
  }

  /** Tries at once: the network seems to be back. */
  retry() {
    this.#pause.end();
  }

  async #run() {
    const { send, save, onSent, onRefused, onLink, signal } = this.#options;
    for (let failures = 0; this.#letters.length > 0 && !signal?.aborted;) {
      const [letter] = this.#letters;
      try {
        const answer = await send(letter);
        if (failures > 0) onLink(false);
        failures = 0;
        this.#remove(letter);
        onSent(letter, answer);
      } catch (error) {
        if (signal?.aborted) return;
        if (isUnavailable(error)) {
          if (failures === 0) onLink(true);
          await this.#pause.wait(reconnectPause(failures));
          failures += 1;
          continue;
        }
        if (!(error instanceof ApiError)) throw error;
        this.#remove(letter);
        onRefused(letter, error);
      }
      save();
    }
  }

  /** @param {Letter} letter */
  #remove(letter) {
    this.#letters = this.#letters.filter((each) => each !== letter);
  }
}
