// Link of a device to its rig at the service: polls the rig's state, and reports since when a moment can have been
// opened.
import { Pause } from "../lib/capture/pause.js";
import { isUnavailable } from "../lib/session.js";

/** @import { RigService, RigState } from "./service.js" */

const POLL_MS = 1_000;
const CHANGED_POLL_MS = 400; // after a change: the next one is near
const OFFLINE_POLL_MS = 2_000;

/**
 * @typedef {object} Options
 * @property {RigService} service
 * @property {string} id of the rig
 * @property {string} session id of a member
 * @property {AbortSignal} signal
 * @property {(state: RigState, unopenedAt: number) => void} onState unopenedAt: ms, when the previous state was
 *   requested, which lacked anything that is new in this one; −∞ for the first
 * @property {(offline: boolean) => void} onLink
 * @property {(error: unknown) => void} onFailure
 */

export class RigLink {
  #options;
  #etag = "";
  #unopenedAt = -Infinity;
  /** @type {RigState["status"] | null} */
  #status = null;
  #pause = new Pause();

  /** @param {Options} options */
  constructor(options) {
    this.#options = options;
  }

  /** Polls until the rig is finished. */
  async run() {
    const { service, id, session, signal, onLink, onFailure } = this.#options;
    while (!signal.aborted && this.#status !== "finished") {
      const askedAt = performance.now();
      let pause = POLL_MS;
      try {
        const found = await service.state(id, session, this.#etag);
        if (signal.aborted) return;
        onLink(false);
        if (found) {
          this.#etag = found.etag;
          this.receive(found.state, askedAt);
          pause = CHANGED_POLL_MS;
        } else this.#unopenedAt = Math.max(this.#unopenedAt, askedAt);
      } catch (error) {
        if (signal.aborted) return;
        if (!isUnavailable(error)) return onFailure(error);
        onLink(true);
        pause = OFFLINE_POLL_MS;
      }
      await this.#pause.wait(pause);
    }
  }

  /** Adopts a state, from any response. @param {RigState} state @param {number} askedAt ms */
  receive(state, askedAt) {
    this.#status = state.status;
    const before = this.#unopenedAt;
    this.#unopenedAt = Math.max(before, askedAt);
    this.#options.onState(state, before);
  }

  /** Polls at once. */
  hurry() {
    this.#pause.end();
  }
}
