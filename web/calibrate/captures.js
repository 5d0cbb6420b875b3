// The captures of this page and of earlier ones, by what they are about: each can be taken up again.
import { OfflineError } from "../lib/network.js";
import { keptSettings, loadSettings } from "../lib/settings.js";
import { Api, ApiError, PAUSES } from "../lib/api.js";
import { CaptureSession, isAway } from "../lib/session.js";

/**
 * @typedef {import("../lib/session.js").SessionRequest} Request
 * @typedef {import("../lib/session.js").SessionState} SessionState
 *
 * @typedef {object} Run
 * @property {AbortSignal} signal
 * @property {(patience: {attempt: number} | null) => void} onPatience
 */

/** ms that a fit of fifteen views takes at most, ten times over: who is silent for longer is away. */
const ANSWER = 10_000;
const SETTINGS = 5_000; // ms

/** What a capture is about, as text: how it was focused does not belong to it. @param {Request} request */
export const captureKey = ({ track, ...request }) => JSON.stringify(request);

export class Captures {
  #store;
  #address;
  #onUnkept;
  /** @type {Map<string, CaptureSession>} */
  #sessions = new Map();
  /** Moved here, and not taken up yet: the device may have no room to keep them. @type {Map<string, import("../lib/session.js").Kept>} */
  #moved = new Map();
  /** What the service has answered in this page, by kind. @type {Set<string>} */
  #known = new Set();

  /**
   * @param {import("./capture-store.js").CaptureStore} captureStore
   * @param {{address: () => string, onUnkept: () => void}} page address: of the page that can go on with what is kept;
   *   onUnkept: called where there is no room for it
   */
  constructor(captureStore, { address, onUnkept }) {
    this.#store = captureStore;
    this.#address = address;
    this.#onUnkept = onUnkept;
  }

  /**
   * A session: one that was interrupted, where it is about the same.
   * @param {Request} request @param {Run} run
   * @returns {Promise<{session: CaptureSession, state: SessionState | null}>} state: null while the service is away
   */
  async open(request, run) {
    const { api: base, token } = await settings(run);
    const api = new Api(base, { ...run, patience: ANSWER });
    const about = captureKey(request);
    const kept = this.#moved.get(about) ?? await this.#store.load(about);
    const same = this.#sessions.get(about);
    const session = same ?? new CaptureSession(api, token, request, { about, kept, save: (now) => this.#save(now), known: this.#known });
    this.#sessions.set(about, session);
    this.#moved.delete(about);
    try {
      const state = session.size > 0 || same ? (await session.resume(api)).state : await session.start();
      if (state.status === "converged") this.#sessions.delete(about);
      return { session, state };
    } catch (error) {
      // An hour that is used up is not waited for; all else that passes by itself is.
      if (!isAway(error) || (error instanceof ApiError && error.status === 429)) throw error;
      return { session, state: null };
    }
  }

  /** @param {string} about */
  async forget(about) {
    this.#sessions.delete(about);
    this.#moved.delete(about);
    await this.#store.remove(about);
  }

  /**
   * Makes the views of one capture those of another, which has not sent them yet.
   * @param {CaptureSession} session @param {Request} request @param {number[]} [without] indices of views that are left behind
   */
  async move(session, request, without = []) {
    const kept = { ...session.unsent(without), about: captureKey(request) };
    await this.forget(captureKey(session.request));
    this.#moved.set(kept.about, kept);
    await this.#save(kept);
  }

  /** @param {import("../lib/session.js").Kept} kept */
  async #save(kept) {
    const saved = kept.views.length ? await this.#store.save({ ...kept, address: this.#address() }) : (await this.#store.remove(kept.about), true);
    if (!saved) this.#onUnkept();
  }
}

/** Those of the last visit where there is no network; where there was none yet, they are waited for. @param {Run} run */
async function settings({ signal, onPatience }) {
  for (let attempt = 0; ; attempt++) {
    try {
      const found = await loadSettings({ patience: SETTINGS });
      if (attempt > 0) onPatience(null);
      return found;
    } catch (error) {
      const kept = error instanceof OfflineError && keptSettings();
      if (kept) return kept;
      if (!(error instanceof OfflineError) || attempt === PAUSES.length) throw error;
    }
    onPatience({ attempt: attempt + 1 });
    await new Promise((resolve) => setTimeout(resolve, 1000 * PAUSES[attempt]));
    signal.throwIfAborted();
  }
}
