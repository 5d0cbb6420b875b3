// Queue of a capture's requests to the service, one at a time, and its offline mode for when no response comes.
import { ApiError } from "../lib/api.js";
import { isUnavailable } from "../lib/session.js";
import { Pause, reconnectPause } from "../lib/capture/pause.js";

/**
 * @typedef {object} Page what a capture needs of the page that it runs in
 * @property {import("./parts.js").Parts} parts
 * @property {() => import("./state.js").State} state as it is now
 * @property {(event: import("./state.js").Event) => void} dispatch
 * @property {(error: unknown, signal: AbortSignal) => void} fail
 * @property {() => Promise<import("../lib/detector.js").Detector>} openDetector a new one if the last has failed
 *
 * @typedef {object} QueueOptions
 * @property {(event: import("./state.js").Event) => void} dispatch
 * @property {AbortSignal} signal
 * @property {() => void} onOffline called when the service is away: the page then chooses the targets
 * @property {() => Promise<void>} onOnline called when it is back
 */

const RESPONSE_MS = 2_000; // without a response, then the capture continues offline
const FIRST_RESPONSE_MS = 5_000; // for the first request of a kind: an idle function has to start

export class RequestQueue {
  #page;
  #session;
  #options;
  /** The request in flight. */
  #inFlight = Promise.resolve();
  /** True if a request that timed out may still be answered. */
  isOverdue = false;
  #pause = new Pause();
  /** Number of replaced sessions of which the visitor was notified. */
  #notifiedRenewals = 0;

  /**
   * @param {Page} page @param {import("../lib/session.js").CaptureSession} session
   * @param {QueueOptions} options
   */
  constructor(page, session, options) {
    this.#page = page;
    this.#session = session;
    this.#options = options;
  }

  get #state() {
    return this.#page.state();
  }

  /**
   * Sends a request, unless another one is in flight: automatic requests do not queue.
   * @template T
   * @param {() => Promise<T>} request
   * @param {(response: T) => void} deliver called if the response was in time
   */
  send(request, deliver) {
    if (!this.#state.link.busy) this.#inFlight = this.#run(request, deliver);
    return this.#inFlight;
  }

  /** @template T @param {() => Promise<T>} request @param {(response: T) => void} deliver */
  async #run(request, deliver) {
    const { dispatch, signal } = this.#options;
    dispatch({ type: "busy" });
    const timeout = new ResponseTimeout(RESPONSE_MS, () => this.#leave());
    this.#session.onRequest = (isFirst) => timeout.restart(isFirst ? FIRST_RESPONSE_MS : RESPONSE_MS);
    this.#session.onResponse = () => timeout.restart();
    try {
      const response = await request();
      // Only the service knows how many of the views a new session took.
      const renewed = this.#session.renewals > this.#notifiedRenewals ? (await this.#session.resume()).state : null;
      if (timeout.expired) return this.#settle(true);
      deliver(response);
      dispatch({ type: "idle" });
      if (!renewed) return;
      dispatch({ type: "session", session: renewed, time: performance.now() });
      this.#notifyRenewal();
    } catch (error) {
      timeout.cancel();
      if (signal.aborted) return;
      const conflict = error instanceof ApiError && error.status === 409;
      if (timeout.expired && (conflict || isUnavailable(error))) this.#settle(false);
      else if (isUnavailable(error)) this.#handleOutage();
      else if (conflict) await this.#resynchronize();
      else this.#page.fail(error, signal);
    } finally {
      timeout.cancel();
    }
  }

  /** Continues offline after a timeout; the request may still be answered. */
  #leave() {
    const { dispatch, signal, onOffline } = this.#options;
    if (signal.aborted || this.#state.link.offline || this.#state.phase !== "capturing") return;
    this.isOverdue = true;
    dispatch({ type: "offline", stored: this.#session.stored(this.#state.capture) });
    onOffline();
  }

  /** The overdue request has been answered after all, or has failed. @param {boolean} isAnswered */
  #settle(isAnswered) {
    this.isOverdue = false;
    if (this.#state.link.offline) void this.#reconnect(isAnswered);
    else this.#options.dispatch({ type: "idle" });
  }

  /** Adopts the service's state of the session, which differs from the page's after a lost response. */
  async #resynchronize() {
    const { dispatch, signal, onOnline } = this.#options;
    try {
      const { state } = await this.#session.resume();
      dispatch({ type: "session", session: state, time: performance.now() });
      dispatch({ type: "idle" });
      this.#notifyRenewal();
      if (this.#state.phase === "capturing") setTimeout(() => void onOnline(), 0);
    } catch (error) {
      if (isUnavailable(error)) this.#handleOutage();
      else this.#page.fail(error, signal);
    }
  }

  /** Notifies the visitor, once, that a new session replaces an expired one. */
  #notifyRenewal() {
    if (this.#session.renewals === this.#notifiedRenewals) return;
    this.#notifiedRenewals = this.#session.renewals;
    this.#options.dispatch({
      type: "notice",
      notice: { key: "capture.begun_anew", kind: "plain" },
      time: performance.now(),
    });
  }

  #handleOutage() {
    const { dispatch } = this.#options;
    if (this.#state.link.offline) return dispatch({ type: "idle" });
    dispatch({ type: "offline", stored: this.#session.stored(this.#state.capture) });
    this.goOffline();
  }

  /** Continues without the service: uses targets of the plan, stores views, and reconnects when it can. */
  goOffline() {
    this.#options.onOffline();
    void this.#reconnect();
  }

  /** @param {boolean} [isBack] the service has just answered: the first attempt follows at once */
  async #reconnect(isBack = false) {
    const { dispatch, signal, onOnline } = this.#options;
    const onSending = () => dispatch({ type: "sending", sending: true });
    let [taken, refused] = [0, 0];
    let failures = 0;
    while (!signal.aborted) {
      if (!isBack) await this.#pause.wait(reconnectPause(failures++));
      if (signal.aborted) return;
      try {
        const sent = await this.#session.resume(undefined, { onSending });
        [taken, refused] = [taken + sent.taken, refused + sent.refused];
        // Views that were stored while earlier ones were sent follow at once.
        isBack = this.#session.waiting > 0 && sent.state.status !== "converged";
        if (isBack) continue;
        dispatch({ type: "online", session: sent.state, taken, refused, time: performance.now() });
        this.#notifyRenewal();
        break;
      } catch (error) {
        if (!isUnavailable(error)) return this.#page.fail(error, signal);
        isBack = false;
        dispatch({ type: "sending", sending: false });
      }
    }
    if (this.#state.phase === "capturing") await onOnline();
  }

  /** Resolves when no request is in flight: the visitor's actions wait for their turn. */
  async drained() {
    while (this.#state.link.busy && !this.#options.signal.aborted) await this.#inFlight;
  }
}

/** Timeout for responses of the service: restarted by each request and each response. */
class ResponseTimeout {
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
