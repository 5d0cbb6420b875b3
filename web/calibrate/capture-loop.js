// Loop of one capture: detects the board, sends what is held still, sets the targets, and continues after failures.
import { facts, lockFocus } from "../lib/camera.js";
import { DetectorError, grab } from "../lib/detector.js";
import { Pace, nextFrame } from "../lib/frames.js";
import { decide, lenience } from "./hold.js";
import { nextPlanned, trustedCalibration } from "./plan.js";
import { RequestQueue } from "./request-queue.js";
import { isEnough, isFinishable, isOfSize, isSharpestOffered, viewCount } from "./state.js";
import { isSettled } from "../lib/capture/sight.js";
import { motion } from "../lib/capture/stillness.js";
import { Sharpest } from "../lib/rank.js";
import { tint } from "./tint.js";

/**
 * @typedef {import("./state.js").Event} Event
 *
 * @typedef {import("./request-queue.js").Page} Page
 *
 * @typedef {object} Resources
 * @property {import("../lib/session.js").CaptureSession} session
 * @property {Promise<Detector>} detector the first target is shown while it is loaded
 * @property {import("../lib/camera.js").OpenCamera} camera
 * @property {import("./plan.js").Step[]} plan
 * @property {AbortSignal} signal
 *
 * @typedef {import("../lib/detector.js").Detector} Detector
 */

const MAX_MOTION_PX = 3; // between the hold's last frame and the one that is sent, at 1280 px width
const MIN_RELATIVE_SHARPNESS = 0.75; // of the hold's frames: less is one blurred frame, and the next one will do
const SHARPNESS_FRAMES = 12; // over which the median sharpness is taken
const MAX_SHARPEST = 12; // frames of a moving board: a few more than a capture takes
const MAX_RESTARTS = 3; // of the detector in one capture: a fourth would not help

export class CaptureLoop {
  #page;
  #session;
  #opening;
  /** @type {Detector | null} */
  #detector = null;
  #camera;
  #plan;
  #signal;
  #planned = 0;
  #restarts = 0;
  #isFocused = false;
  #wasHidden = false;
  #isFirst = true;
  #isFinishing = false;
  #isLooking = false;
  /** @type {import("../lib/capture/board-watch.js").BoardWatch | null} loaded when no corner is seen */
  #watch = null;
  #sharpest = new Sharpest();
  /** @type {number[]} of the last frames */
  #sharpness = [];
  #pace = new Pace();
  #queue;

  /** @param {Page} page @param {Resources} resources */
  constructor(page, { session, detector, camera, plan, signal }) {
    this.#page = page;
    this.#session = session;
    this.#opening = detector;
    this.#camera = camera;
    this.#plan = plan;
    this.#signal = signal;
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
    document.addEventListener("keydown", (event) => this.#handleKey(event), { signal });
  }

  get #state() {
    return this.#page.state();
  }

  get #video() {
    return this.#page.parts.video;
  }

  /**
   * Processes one frame after the other until the session has converged.
   * @returns {Promise<"relayout" | null>} relayout: the capture is to begin again with the board's other layout
   */
  async run() {
    if (this.#state.link.offline) this.#queue.goOffline();
    else void this.#fetchTarget();
    this.#detector = await this.#opening;
    this.#dispatch({ type: "loading", fraction: 1 });
    this.#dispatch({ type: "visible", time: performance.now() });
    while (this.#state.phase === "capturing" && !this.#signal.aborted) {
      await nextFrame(this.#video);
      if (this.#signal.aborted || this.#isHidden()) continue;
      const began = performance.now();
      const detection = await this.#detect();
      if (this.#signal.aborted) return null;
      if (!detection) continue;
      const taken = performance.now() - began;
      this.#dispatch({ type: "frame", detection, time: performance.now() });
      this.#measure(detection, taken);
      this.#focus();
      void this.#look();
      const action = decide(this.#state, performance.now());
      if (action === "relayout") return action;
      if (action === "submit") await this.#submit();
      else if (action === "finish") await this.#finish();
      else if (action === "skip") void this.#fetchTarget({ skip: true });
    }
    return null;
  }

  /** @param {import("../lib/detector.js").Detection} detection @param {number} taken ms */
  #measure({ metrics, size }, taken) {
    // If colouring the picture takes the time that detection needs, the target is drawn in a plainer way.
    if (!this.#state.ui.plain && this.#pace.isSlow(taken)) this.#dispatch({ type: "slow" });
    if (this.#isFirst) performance.mark("first detection");
    this.#isFirst = false;
    const {
      sight: { corners, outline },
      detector: { restless },
    } = this.#state;
    if (restless > 0 && metrics?.sharpness)
      this.#sharpest.add({ ...corners, outline, sharpness: metrics.sharpness }, size[0]);
    if (metrics?.sharpness) this.#sharpness = [...this.#sharpness, metrics.sharpness].slice(-SHARPNESS_FRAMES);
  }

  /** True if the tab is hidden: then no board is in front of it. */
  #isHidden() {
    const hidden = document.hidden;
    if (this.#wasHidden && !hidden) {
      this.#dispatch({ type: "visible", time: performance.now() });
      this.#notify("capture.was_hidden");
    }
    this.#wasHidden = hidden;
    return hidden;
  }

  /**
   * Runs one frame through the detector; null if the detector stopped and another one had to be made.
   * @param {{full?: boolean}} [options]
   */
  async #detect(options) {
    const detector = this.#detector ?? (await this.#opening);
    try {
      return await detector.detect(await grab(this.#video), { ...options, flip: this.#state.wanted.flipped });
    } catch (error) {
      if (!(error instanceof DetectorError) || this.#signal.aborted || ++this.#restarts > MAX_RESTARTS) throw error;
      console.info("the detector is restarted:", error.message);
    }
    this.#dispatch({ type: "stalled", stalled: true });
    detector.close();
    this.#detector = await this.#page.openDetector();
    this.#dispatch({ type: "stalled", stalled: false });
    this.#dispatch({ type: "visible", time: performance.now() });
    return null;
  }

  /**
   * Looks for another board if the expected one is not seen. The next frame reports a failure of the detector.
   */
  async #look() {
    const {
      board,
      wanted: { flipped },
      sight: {
        diagnosis: { blindSince },
      },
    } = this.#state;
    const detector = this.#detector;
    if (!detector || this.#isLooking || viewCount(this.#state) > 0) return;
    if (this.#watch ? !this.#watch.isDue(blindSince, performance.now()) : blindSince === Infinity) return;
    this.#isLooking = true;
    try {
      const watch = (this.#watch ??= new (await import("../lib/capture/board-watch.js")).BoardWatch());
      if (!watch.isDue(blindSince, performance.now())) return;
      const sighting = await detector.sight(await grab(this.#video), { flip: flipped });
      const time = performance.now();
      this.#dispatch({ type: "looked", suggestion: watch.add(sighting, board, time), time });
    } catch (error) {
      if (!(error instanceof DetectorError)) throw error;
    } finally {
      this.#isLooking = false;
    }
  }

  #focus() {
    if (this.#isFocused || !isSettled(this.#state.sight, this.#state.board)) return;
    this.#isFocused = true;
    void this.#lockFocus();
  }

  /** Locks the focus. The track's recorded settings are from before: a session without views is replaced. */
  async #lockFocus() {
    const before = JSON.stringify(this.#session.request.track);
    await lockFocus(this.#camera.track);
    const track = facts(this.#camera.track);
    if (this.#signal.aborted || JSON.stringify(track) === before) return;
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
    const {
      capture: { key },
      sight,
    } = this.#state;
    const { target } = sight;
    if (!target || !key) return;
    const detection = await this.#detect({ full: true });
    if (!detection || this.#signal.aborted) return;
    const { ids, points, size, metrics } = detection;
    // Between the two frames the device may have turned, the hold may have ended, or the hand may have jerked.
    if (!isOfSize(size, key)) return this.#dispatch({ type: "frame", detection, time: performance.now() });
    const usual = [...this.#sharpness].sort((a, b) => a - b)[this.#sharpness.length >> 1];
    if (metrics?.sharpness && usual && metrics.sharpness < MIN_RELATIVE_SHARPNESS * usual) return;
    const corners = { ids, points };
    const steady = (MAX_MOTION_PX * key.img_size[0] * lenience(this.#state, performance.now())) / 1280;
    if (ids.length === 0 || motion(sight.corners, corners) > steady) return;
    if (this.#state.link.offline) {
      this.#session.store(corners);
      const stored = this.#session.stored(this.#state.capture);
      this.#dispatch({ type: "stored", corners, stored, time: performance.now() });
      return this.#continue();
    }
    // Detection continues meanwhile: the service may be slow or unavailable.
    void this.#queue
      .send(
        () => {
          this.#dispatch({ type: "sent", corners });
          return this.#session.submit(target.index, corners);
        },
        (answer) => this.#dispatch({ type: "answer", answer, corners, time: performance.now() }),
      )
      .then(() => this.#continue());
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
      await this.#queue.send(
        () => {
          this.#dispatch({ type: "sent", corners });
          return this.#session.submit(target.index, corners);
        },
        (answer) => this.#dispatch({ type: "answer", answer, corners, time: performance.now() }),
      );
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

  /** @param {import("../lib/session.js").Pose} pose @param {string | null} picture object URL */
  #setTarget(pose, picture) {
    this.#dispatch({ type: "pose", pose, picture, time: performance.now() });
    this.#camera.virtual?.follow(pose);
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

  /** @param {KeyboardEvent} event */
  #handleKey(event) {
    if (event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
    const fields = "input:not([type=checkbox]), select, textarea, [contenteditable]";
    if (event.target instanceof Element && event.target.closest(fields)) return;
    const key = event.key.toLowerCase();
    if (key === "u") void this.#undo();
    else if (key === "n") void this.#skip();
    else return;
    event.preventDefault();
  }
}
