// Guided capture of one camera: sets the targets of its session, sends what is held still, and continues after
// failures.
import { facts } from "../lib/camera.js";
import { Engine } from "../lib/capture/engine.js";
import { lenienceAfter } from "../lib/capture/target.js";
import { pressByKeys } from "../lib/dom.js";
import { Sharpest } from "../lib/rank.js";
import { Pace } from "../lib/frames.js";
import { decide } from "./guidance.js";
import { loadPlan, nextPlanned, trustedCalibration } from "./plan.js";
import { RequestQueue } from "./request-queue.js";
import { isEnough, isFinishable, isSharpestOffered, viewCount } from "./state.js";
import { tint } from "./tint.js";

/**
 * @import { CaptureSession, Pose } from "../lib/session.js"
 * @import { Page } from "./request-queue.js"
 * @import { Event } from "./state.js"
 */

/**
 * @typedef {object} Resources
 * @property {CaptureSession} session
 * @property {Promise<unknown>} detector the first target is shown while it is loaded
 * @property {import("../lib/capture/streams.js").Stream} stream of the camera
 * @property {import("./plan.js").Step[]} plan
 * @property {AbortSignal} signal
 */

export { loadPlan };
const MAX_SHARPEST = 12; // frames of a moving board: a few more than a capture takes

export class CaptureLoop {
  #page;
  #session;
  #opening;
  #stream;
  #plan;
  #signal;
  #camera;
  #engine;
  #planned = 0;
  #isFirst = true;
  #isFinishing = false;
  #isOtherLayout = false;
  #sharpest = new Sharpest();
  #pace = new Pace();
  #queue;

  /** @param {Page} page @param {Resources} resources */
  constructor(page, { session, detector, stream, plan, signal }) {
    this.#page = page;
    this.#session = session;
    this.#opening = detector;
    this.#stream = stream;
    this.#plan = plan;
    this.#signal = signal;
    this.#camera = { stream, half: 0 };
    this.#engine = new Engine(this, {
      cameras: [this.#camera],
      board: () => this.#state.board,
      openDetector: page.openDetector,
      isFlipped: () => this.#state.wanted.flipped === true,
      signal,
    });
    this.#queue = new RequestQueue(page, session, {
      dispatch: (event) => this.#dispatch(event),
      signal,
      onOffline: () => this.#setPlannedTarget(),
      onOnline: () => this.#return(),
    });
    const on = (/** @type {HTMLElement} */ button, /** @type {() => void} */ action) =>
      button.addEventListener("click", action, { signal });
    on(page.parts.undo, () => this.#undo());
    on(page.parts.skip, () => this.#skip());
    on(page.parts.finish, () => this.#finish());
    on(page.parts.sharpest, () => this.#useSharpest());
    pressByKeys({ u: page.parts.undo, n: page.parts.skip }, signal);
  }

  get #state() {
    return this.#page.state();
  }

  /**
   * Processes one frame after the other until the session has converged.
   * @returns {Promise<"relayout" | null>} relayout: the capture is to begin again with the board's other layout
   */
  async run() {
    if (this.#state.link.offline) this.#queue.goOffline();
    else void this.#fetchTarget();
    await this.#opening;
    this.#dispatch({ type: "loading", fraction: 1 });
    this.#dispatch({ type: "visible", time: performance.now() });
    await this.#engine.run();
    return this.#isOtherLayout && !this.#signal.aborted ? "relayout" : null;
  }

  isOver() {
    return this.#isOtherLayout || this.#state.phase !== "capturing";
  }

  sight() {
    return this.#state.sight;
  }

  /** @param {unknown} _ @param {import("../lib/detector.js").Detection} detection @param {number} taken ms */
  observe(_, detection, taken) {
    this.#dispatch({ type: "frame", detection, time: performance.now() });
    // If colouring the picture takes the time that detection needs, the target is drawn in a plainer way.
    if (!this.#state.ui.plain && this.#pace.isSlow(taken)) this.#dispatch({ type: "slow" });
    if (this.#isFirst) performance.mark("first detection");
    this.#isFirst = false;
    const { metrics, size } = detection;
    const {
      sight: { corners, outline },
      detector: { restless },
    } = this.#state;
    if (restless > 0 && metrics?.sharpness)
      this.#sharpest.add({ ...corners, outline, sharpness: metrics.sharpness }, size[0]);
  }

  async act() {
    const action = decide(this.#state, performance.now());
    if (action === "relayout") this.#isOtherLayout = true;
    else if (action === "submit") await this.#submit();
    else if (action === "finish") await this.#finish();
    else if (action === "skip") void this.#fetchTarget({ skip: true });
  }

  /** True before the first view: then another board may be meant. */
  isSearched() {
    return viewCount(this.#state) === 0;
  }

  /** @param {unknown} _ @param {import("../lib/board-recognition.js").Recognised | null} suggestion */
  suggest(_, suggestion) {
    this.#dispatch({ type: "looked", suggestion, time: performance.now() });
  }

  onReturn() {
    this.#dispatch({ type: "visible", time: performance.now() });
    this.#notify("capture.was_hidden");
  }

  /** @param {boolean} stalled */
  onStalled(stalled) {
    this.#dispatch({ type: "stalled", stalled });
    if (!stalled) this.#dispatch({ type: "visible", time: performance.now() });
  }

  onResized() {
    this.#dispatch({ type: "failed", code: "resized" });
  }

  /** The track's recorded settings are from before the focus was locked: a session without views is replaced. */
  async onFocused() {
    const track = facts(this.#stream.camera.track);
    if (JSON.stringify(track) === JSON.stringify(this.#session.request.track)) return;
    await this.#queue.drained();
    if (this.#signal.aborted) return;
    this.#session.track(track);
    const {
      phase,
      capture: { session },
      link: { offline },
    } = this.#state;
    if (phase !== "capturing" || (session && (offline || viewCount(this.#state) > 0))) return;
    this.#dispatch({ type: "request", request: this.#session.request });
    if (!session) return; // it starts once the service is available
    await this.#queue.send(
      () => this.#session.start(),
      (started) => this.#dispatch({ type: "session", session: started, time: performance.now() }),
    );
    if (this.#state.phase === "capturing") await this.#fetchTarget();
  }

  async #submit() {
    const { target } = this.#state.sight;
    const lenience = () => lenienceAfter(performance.now() - this.#state.capture.posedAt);
    const taken = target && (await this.#engine.take(this.#camera, { lenience }));
    if (!taken) return;
    const { corners } = taken;
    if (this.#state.link.offline) {
      this.#session.store(corners);
      const stored = this.#session.stored(this.#state.capture);
      this.#dispatch({ type: "stored", corners, stored, time: performance.now() });
      return this.#continue();
    }
    // Detection continues meanwhile: the service may be slow or unavailable.
    void this.#send(target, corners).then(() => this.#continue());
  }

  /** @param {Pose} target @param {import("../lib/board-outline.js").Corners} corners */
  #send(target, corners) {
    return this.#queue.send(
      () => {
        this.#dispatch({ type: "sent", corners });
        return this.#session.submit(target.index, corners);
      },
      (answer) => this.#dispatch({ type: "answer", answer, corners, time: performance.now() }),
    );
  }

  /** Sends the sharpest frames of a board that was never held still, and ends the capture with those that agree. */
  async #useSharpest() {
    await this.#queue.drained();
    const { key } = this.#state.capture;
    if (!key || !isSharpestOffered(this.#state)) return;
    for (const corners of this.#sharpest.best(MAX_SHARPEST, key.img_size)) {
      if (!this.#state.sight.target) await this.#fetchTarget();
      const {
        phase,
        sight: { target },
      } = this.#state;
      if (phase !== "capturing" || !target || this.#signal.aborted) return;
      await this.#send(target, corners);
    }
    if (this.#state.phase !== "capturing") return;
    if (isFinishable(this.#state)) await this.#finish();
    else this.#notify("capture.sharpest_few");
  }

  #continue() {
    if (!this.#signal.aborted && this.#state.phase === "capturing" && !this.#state.sight.target)
      void this.#fetchTarget();
  }

  /** @param {{skip?: boolean}} [options] */
  #fetchTarget(options) {
    if (this.#state.link.offline) return Promise.resolve(this.#setPlannedTarget());
    return this.#queue.send(
      async () => {
        const { pose, picture } = await this.#session.pose(options);
        const { key } = this.#state.capture;
        return { pose, tinted: key ? await tint(picture, pose.outline, key.img_size) : picture };
      },
      ({ pose, tinted }) => {
        if (!this.#signal.aborted) this.#setTarget(pose, URL.createObjectURL(tinted));
      },
    );
  }

  /** Sets a target of the page's own plan, if there is one. */
  #setPlannedTarget() {
    const {
      board,
      capture: { key, session },
    } = this.#state;
    if (isEnough(this.#state)) return;
    const planned = key && nextPlanned(this.#plan, this.#planned, board, key.img_size, trustedCalibration(session));
    if (!planned) return;
    this.#planned = planned.next;
    this.#setTarget(planned.pose, null);
  }

  /** @param {Pose} pose @param {string | null} picture object URL */
  #setTarget(pose, picture) {
    this.#dispatch({ type: "pose", pose, picture, time: performance.now() });
    this.#stream.camera.virtual?.follow(pose);
  }

  async #skip() {
    await this.#queue.drained();
    if (this.#state.phase === "capturing") await this.#fetchTarget({ skip: true });
  }

  /** Repeats the last request once the service is back. */
  async #return() {
    if (this.#isFinishing) await this.#finish();
    if (!this.#signal.aborted && this.#state.phase === "capturing") await this.#fetchTarget();
  }

  /** Ends the capture with the views that are there; while the service is away, as soon as it is back. */
  async #finish() {
    await this.#queue.drained();
    this.#isFinishing = this.#state.link.offline;
    if (!isFinishable(this.#state)) return;
    await this.#queue.send(
      () => this.#session.finish(),
      (session) => this.#dispatch({ type: "session", session, time: performance.now() }),
    );
  }

  async #undo() {
    await this.#queue.drained();
    const { phase, link } = this.#state;
    if (phase !== "capturing" || viewCount(this.#state) === 0) return;
    // Only the service can undo a view that it has, or is just being sent.
    if (link.offline && (link.sending || this.#queue.isOverdue || this.#session.lastIsTaken)) {
      return this.#notify("capture.undo_away");
    }
    await this.#queue.send(
      () => this.#session.undo(),
      (session) => {
        const stored = this.#session.stored(this.#state.capture);
        this.#dispatch({ type: "undone", session, stored, time: performance.now() });
      },
    );
    await this.#fetchTarget();
  }

  /** @param {string} key of a message */
  #notify(key) {
    this.#dispatch({ type: "notice", notice: { key, kind: "plain" }, time: performance.now() });
  }

  /** Dispatches, unless the capture has ended. @param {Event} event */
  #dispatch(event) {
    if (!this.#signal.aborted) this.#page.dispatch(event);
  }
}
