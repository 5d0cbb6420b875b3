// Captures of this page and of earlier ones, by key: each can be resumed.
import { Api, ApiError, RETRY_DELAYS_S } from "../lib/api.js";
import { explain } from "../lib/faults.js";
import { OfflineError } from "../lib/network.js";
import { CaptureSession, isUnavailable } from "../lib/session.js";
import { SettingsError, lastSettings } from "../lib/settings.js";
import { captureKey } from "./state.js";

/** @import { SavedCapture, SessionRequest as Request, SessionState } from "../lib/session.js" */

/**
 * @typedef {object} Run
 * @property {AbortSignal} signal
 * @property {(retry: {attempt: number} | null) => void} onRetry
 */

const RESPONSE_TIMEOUT_MS = 10_000; // ten times as long as a fit of fifteen views takes
const SETTINGS_TIMEOUT_MS = 5_000;

/**
 * Code of a message `capture.fault_<code>` about the service, and its reason.
 * @param {unknown} error @returns {{code: string, detail: string} | null} null: another error
 */
export function serviceFault(error) {
  if (error instanceof SettingsError) return { code: "settings", detail: error.message };
  if (error instanceof ApiError) return { code: "service", detail: explain(error) };
  return null;
}

export class Captures {
  #store;
  #address;
  #onUnsaved;
  /** @type {Map<string, CaptureSession>} */
  #sessions = new Map();
  /** Moved and not yet opened: the device may have no room to save them. @type {Map<string, SavedCapture>} */
  #moved = new Map();
  /** Kinds of requests that the service has answered in this page. @type {Set<string>} */
  #answered = new Set();

  /**
   * @param {import("../lib/capture/capture-store.js").CaptureStore} captureStore
   * @param {{address: () => string, onUnsaved: () => void}} page address: of the page that can resume the capture;
   *   onUnsaved: called when there is no room for it
   */
  constructor(captureStore, { address, onUnsaved }) {
    this.#store = captureStore;
    this.#address = address;
    this.#onUnsaved = onUnsaved;
  }

  /**
   * Opens a session, or resumes the interrupted one with the same key.
   * @param {Request} request @param {Run} run
   * @returns {Promise<{session: CaptureSession, state: SessionState | null}>} state: null while the service is away
   */
  async open(request, run) {
    const { api: base, token } = await fetchSettings(run);
    const api = new Api(base, { ...run, timeout: RESPONSE_TIMEOUT_MS });
    const about = captureKey(request);
    const saved = this.#moved.get(about) ?? (await this.#store.load(about));
    const same = this.#sessions.get(about);
    const memory = {
      about,
      saved,
      save: (/** @type {SavedCapture} */ capture) => this.#save(capture),
      answered: this.#answered,
    };
    const session = same ?? new CaptureSession(api, token, request, memory);
    this.#sessions.set(about, session);
    this.#moved.delete(about);
    try {
      const state = session.size > 0 || same ? (await session.resume(api)).state : await session.start();
      if (state.status === "converged") this.#sessions.delete(about);
      return { session, state };
    } catch (error) {
      // A used-up quota is not waited for; all other passing failures are.
      if (!isUnavailable(error) || (error instanceof ApiError && error.status === 429)) throw error;
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
   * Moves the views of one capture to another, which has not sent them yet.
   * @param {CaptureSession} session @param {Request} request @param {number[]} [without] indices of views to leave out
   */
  async move(session, request, without = []) {
    const moved = { ...session.unsent(without), about: captureKey(request) };
    await this.forget(captureKey(session.request));
    this.#moved.set(moved.about, moved);
    await this.#save(moved);
  }

  /** @param {SavedCapture} capture */
  async #save(capture) {
    if (capture.views.length === 0) await this.#store.remove(capture.about);
    else if (!(await this.#store.save({ ...capture, address: this.#address() }))) this.#onUnsaved();
  }
}

/**
 * Settings of the page; without a network those of the last visit, which the first visit waits for.
 * @param {Run} run
 */
async function fetchSettings({ signal, onRetry }) {
  for (let attempt = 0; ; attempt++) {
    try {
      const found = await lastSettings({ timeout: SETTINGS_TIMEOUT_MS });
      if (attempt > 0) onRetry(null);
      return found;
    } catch (error) {
      if (!(error instanceof OfflineError) || attempt === RETRY_DELAYS_S.length) throw error;
    }
    onRetry({ attempt: attempt + 1 });
    await new Promise((resolve) => setTimeout(resolve, 1000 * RETRY_DELAYS_S[attempt]));
    signal.throwIfAborted();
  }
}
