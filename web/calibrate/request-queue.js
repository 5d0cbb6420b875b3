// What a capture says to the service, one thing at a time, and how it does without where nothing comes back.
import { ApiError } from "../lib/api.js";
import { ResponseTimeout } from "./response-timeout.js";
import { isAway } from "../lib/session.js";

/**
 * @typedef {object} Means
 * @property {(event: import("./state.js").Event) => void} tell
 * @property {AbortSignal} signal
 * @property {() => void} onAway the service is away: targets are the page's own
 * @property {() => Promise<void>} onBack it is there again
 */

const PATIENCE = 2_000; // ms without an answer: then it goes on without the service
const AT_FIRST = 5_000; // ms the first time: a function that nobody has asked for a while has to start
const RECONNECT = [1, 2, 3, 4, 5]; // s between attempts; the last one again and again

export class RequestQueue {
  #page;
  #session;
  #means;
  /** What is being asked. */
  #inFlight = Promise.resolve();
  /** Was something asked that is not waited for any more? */
  late = false;

  /** @param {import("./capture-loop.js").Page} page @param {import("../lib/session.js").CaptureSession} session @param {Means} means */
  constructor(page, session, means) {
    this.#page = page;
    this.#session = session;
    this.#means = means;
  }

  get #state() {
    return this.#page.state();
  }

  /**
   * One conversation with the service at a time; what the page does by itself does not queue.
   * @template T @param {() => Promise<T>} ask @param {(answer: T) => void} tell called where the answer came in time
   */
  ask(ask, tell) {
    if (!this.#state.busy) this.#inFlight = this.#run(ask, tell);
    return this.#inFlight;
  }

  /** @template T @param {() => Promise<T>} ask @param {(answer: T) => void} tell */
  async #run(ask, tell) {
    this.#means.tell({ type: "busy" });
    const { restored } = this.#session;
    const patience = new ResponseTimeout(PATIENCE, () => this.#leave());
    this.#session.onAsk = (isFirst) => patience.renew(isFirst ? AT_FIRST : PATIENCE);
    this.#session.onAnswer = () => patience.renew();
    try {
      const answer = await ask();
      // How many of its views a new session took, only it knows.
      const anew = this.#session.restored > restored ? (await this.#session.resume()).state : null;
      if (patience.lost) return this.#return([0, ...RECONNECT]);
      tell(answer);
      this.#means.tell({ type: "idle" });
      if (!anew) return;
      this.#means.tell({ type: "session", session: anew });
      this.#means.tell({ type: "told", notice: { key: "capture.begun_anew", kind: "plain" }, time: performance.now() });
    } catch (error) {
      patience.end();
      if (this.#means.signal.aborted) return;
      const contrary = error instanceof ApiError && error.status === 409;
      if (patience.lost && (contrary || isAway(error))) this.#return(RECONNECT);
      else if (isAway(error)) this.#goAway();
      else if (contrary) await this.#agree();
      else this.#page.fail(error, this.#means.signal);
    } finally {
      patience.end();
    }
  }

  /** Nothing was heard for too long: it goes on without, and what was asked may still be answered. */
  #leave() {
    if (this.#means.signal.aborted || this.#state.away || this.#state.phase !== "capturing") return;
    this.late = true;
    this.#means.tell({ type: "away", stored: this.#session.stored(this.#state) });
    this.#means.onAway();
  }

  /** What was asked is answered after all, or will never be. @param {number[]} pauses s */
  #return(pauses) {
    this.late = false;
    if (this.#state.away) void this.#reconnect(pauses);
    else this.#means.tell({ type: "idle" });
  }

  /** The service is of another mind about the session, after a lost answer: what it says holds. */
  async #agree() {
    try {
      const { state } = await this.#session.resume();
      this.#means.tell({ type: "session", session: state });
      this.#means.tell({ type: "idle" });
      if (this.#state.phase === "capturing") setTimeout(() => void this.#means.onBack(), 0);
    } catch (error) {
      if (isAway(error)) this.#goAway();
      else this.#page.fail(error, this.#means.signal);
    }
  }

  #goAway() {
    if (this.#state.away) return this.#means.tell({ type: "idle" });
    this.#means.tell({ type: "away", stored: this.#session.stored(this.#state) });
    this.goOffline();
  }

  /** Without the service: targets from the plan, views kept, and asking every now and then. */
  goOffline() {
    this.#means.onAway();
    void this.#reconnect();
  }

  /** @param {number[]} [pauses] s between attempts; the last one again and again */
  async #reconnect(pauses = RECONNECT) {
    let [taken, refused] = [0, 0];
    for (let attempt = 0; !this.#means.signal.aborted; attempt++) {
      await new Promise((resolve) => setTimeout(resolve, 1000 * (pauses[attempt] ?? pauses[pauses.length - 1])));
      if (this.#means.signal.aborted) return;
      try {
        const sent = await this.#session.resume(undefined, { onSending: () => this.#means.tell({ type: "sending", sending: true }) });
        [taken, refused] = [taken + sent.taken, refused + sent.refused];
        if (this.#session.waiting > 0 && sent.state.status !== "converged") continue; // taken while these were sent
        this.#means.tell({ type: "back", session: sent.state, taken, refused, time: performance.now() });
        break;
      } catch (error) {
        if (!isAway(error)) return this.#page.fail(error, this.#means.signal);
        this.#means.tell({ type: "sending", sending: false });
      }
    }
    if (this.#state.phase === "capturing") await this.#means.onBack();
  }

  /** What a person asked for waits for its turn. */
  async drained() {
    while (this.#state.busy && !this.#means.signal.aborted) await this.#inFlight;
  }
}
