// The loop of one capture: looks, sends what is held still, follows the targets, and goes on when something fails.
import { facts, lockFocus } from "../lib/camera.js";
import { RequestQueue } from "./request-queue.js";
import { DetectorError, grab } from "../lib/detector.js";
import { nextProbe } from "./diagnosis.js";
import { Pace, nextFrame } from "../lib/frames.js";
import { decide, isSettled, lenience } from "./hold.js";
import { nextPlanned, trusted } from "./plan.js";
import { isEnough, viewCount } from "../lib/session.js";
import { isOfSize } from "./state.js";
import { motion } from "./stillness.js";
import { tint } from "./tint.js";

/**
 * @typedef {import("./state.js").Event} Event
 *
 * @typedef {object} Page what a capture needs of the page that it runs in
 * @property {import("./render.js").Parts} parts
 * @property {() => import("./state.js").State} state as it is now
 * @property {(event: Event) => void} dispatch
 * @property {(error: unknown, signal: AbortSignal) => void} fail
 * @property {() => Promise<Detector>} openDetector a new one where the last has failed
 *
 * @typedef {import("../lib/session.js").CaptureSession} CaptureSession
 * @typedef {import("../lib/detector.js").Detector} Detector
 * @typedef {import("../lib/camera.js").OpenCamera} OpenCamera
 */

const STEADY = 3; // px between the hold's last frame and the one that is sent, at 1280 px width
const CRISP = 0.75; // of the sharpness that the hold's frames had: less is one blurred frame, and the next one will do
const REMEMBERED = 12; // frames
const RESTARTS = 3; // of the detector in one capture: a fourth would not help

/** The loop of one capture. */
export class CaptureLoop {
  #page;
  #session;
  #detector;
  #camera;
  #plan;
  #signal;
  #planned = 0;
  #restarts = 0;
  #focused = false;
  #hidden = false;
  #looked = false;
  /** @type {number[]} of the last frames */
  #sharpness = [];
  #pace = new Pace();
  #queue;

  /**
   * @param {Page} page
   * @param {{session: CaptureSession, detector: Detector, camera: OpenCamera, plan: import("./plan.js").Step[], signal: AbortSignal}} means
   */
  constructor(page, { session, detector, camera, plan, signal }) {
    this.#page = page;
    this.#session = session;
    this.#detector = detector;
    this.#camera = camera;
    this.#plan = plan;
    this.#signal = signal;
    this.#queue = new RequestQueue(page, session, {
      tell: (event) => this.#tell(event), signal, onAway: () => this.#planPose(), onBack: () => this.#nextPose(),
    });
    const on = (/** @type {HTMLElement} */ button, /** @type {() => void} */ action) =>
      button.addEventListener("click", action, { signal });
    on(page.parts.undo, () => this.#undo());
    on(page.parts.skip, () => this.#skip());
    document.addEventListener("keydown", (event) => this.#key(event), { signal });
  }

  get #state() {
    return this.#page.state();
  }

  get #video() {
    return this.#page.parts.video;
  }

  /**
   * Looks at one frame after the other until the session has converged.
   * @returns {Promise<"relayout" | null>} relayout: the capture is to begin again with the board's other layout
   */
  async run() {
    if (this.#state.away) this.#queue.goOffline();
    else void this.#nextPose();
    while (this.#state.phase === "capturing" && !this.#signal.aborted) {
      await nextFrame(this.#video);
      if (this.#signal.aborted || this.#isHidden()) continue;
      const began = performance.now();
      const detection = await this.#look({ probe: nextProbe(this.#state.diagnosis, performance.now()) });
      if (this.#signal.aborted) return null;
      if (!detection) continue;
      // Where colouring the picture takes the time that looking at it needs, the target is drawn in a plainer way.
      if (!this.#state.plain && this.#pace.isSlow(performance.now() - began)) this.#tell({ type: "slow" });
      if (!this.#looked) performance.mark("first detection");
      this.#looked = true;
      if (detection.metrics?.sharpness) this.#sharpness = [...this.#sharpness, detection.metrics.sharpness].slice(-REMEMBERED);
      this.#tell({ type: "frame", detection, time: performance.now() });
      this.#focus();
      const action = decide(this.#state, performance.now());
      if (action === "relayout") return action;
      if (action === "submit") await this.#submit();
      else if (action === "skip") void this.#nextPose({ skip: true });
    }
    return null;
  }

  /** Nobody holds a board in a tab that is not seen. */
  #isHidden() {
    const hidden = document.hidden;
    if (this.#hidden && !hidden) {
      this.#tell({ type: "shown", time: performance.now() });
      this.#tell({ type: "told", notice: { key: "capture.was_hidden", kind: "plain" }, time: performance.now() });
    }
    this.#hidden = hidden;
    return hidden;
  }

  /**
   * One frame through the detector; null where the detector stopped and another one had to be made.
   * @param {{full?: boolean, probe?: string | null}} options
   */
  async #look(options) {
    try {
      return await this.#detector.detect(await grab(this.#video), options);
    } catch (error) {
      if (!(error instanceof DetectorError) || this.#signal.aborted || ++this.#restarts > RESTARTS) throw error;
      console.info("the detector is started again:", error.message);
    }
    this.#tell({ type: "stalled", stalled: true });
    this.#detector.close();
    this.#detector = await this.#page.openDetector();
    this.#tell({ type: "stalled", stalled: false });
    this.#tell({ type: "shown", time: performance.now() });
    return null;
  }

  #focus() {
    if (this.#focused || !isSettled(this.#state)) return;
    this.#focused = true;
    void this.#lock();
  }

  /** What was recorded of the camera was so before its focus was held: a session without views is begun anew. */
  async #lock() {
    const before = JSON.stringify(this.#session.request.track);
    await lockFocus(this.#camera.track);
    const track = facts(this.#camera.track);
    if (this.#signal.aborted || JSON.stringify(track) === before) return;
    await this.#queue.drained();
    if (this.#signal.aborted) return;
    this.#session.track(track);
    const { phase, session, away } = this.#state;
    if (phase !== "capturing" || (session && (away || viewCount(this.#state) > 0))) return;
    this.#tell({ type: "request", request: this.#session.request });
    if (!session) return; // it is begun once the service is there
    await this.#queue.ask(() => this.#session.start(), (begun) => this.#tell({ type: "session", session: begun }));
    if (this.#state.phase === "capturing") await this.#nextPose();
  }

  async #submit() {
    const { pose, key, corners } = this.#state;
    if (!pose || !key) return;
    const detection = await this.#look({ full: true });
    if (!detection || this.#signal.aborted) return;
    const { ids, points, size, metrics } = detection;
    // Between the two frames the device may have been turned, the hold may have ended, the hand may have jerked.
    if (!isOfSize(size, key)) return this.#tell({ type: "frame", detection, time: performance.now() });
    const usual = [...this.#sharpness].sort((a, b) => a - b)[this.#sharpness.length >> 1];
    if (metrics?.sharpness && usual && metrics.sharpness < CRISP * usual) return;
    const view = { ids, points };
    const steady = (STEADY * key.img_size[0] * lenience(this.#state, performance.now())) / 1280;
    if (ids.length === 0 || motion(corners, view) > steady) return;
    if (this.#state.away) {
      this.#session.keep(view);
      this.#tell({ type: "stored", corners: view, stored: this.#session.stored(this.#state), time: performance.now() });
    } else {
      // Looking goes on meanwhile: the service may take its time, or be away.
      void this.#queue.ask(
        () => {
          this.#tell({ type: "sent", corners: view });
          return this.#session.submit(pose.index, view);
        },
        (answer) => this.#tell({ type: "answer", answer, corners: view, time: performance.now() }),
      ).then(() => this.#goOn());
      return;
    }
    this.#goOn();
  }

  #goOn() {
    if (!this.#signal.aborted && this.#state.phase === "capturing" && !this.#state.pose) void this.#nextPose();
  }

  /** @param {{skip?: boolean}} [options] */
  #nextPose(options) {
    if (this.#state.away) return Promise.resolve(this.#planPose());
    return this.#queue.ask(async () => {
      const { pose, picture } = await this.#session.pose(options);
      return { pose, tinted: await tint(picture) };
    }, ({ pose, tinted }) => {
      if (this.#signal.aborted) return;
      this.#tell({ type: "pose", pose, picture: URL.createObjectURL(tinted), time: performance.now() });
      this.#camera.virtual?.follow(pose);
    });
  }

  /** A target of our own, where there is one. */
  #planPose() {
    const { board, key, session } = this.#state;
    if (isEnough(this.#state)) return;
    const planned = key && nextPlanned(this.#plan, this.#planned, board, key.img_size, trusted(session));
    if (!planned) return;
    const { pose, next } = planned;
    this.#planned = next;
    this.#tell({ type: "pose", pose, picture: null, time: performance.now() });
    this.#camera.virtual?.follow(pose);
  }

  async #skip() {
    await this.#queue.drained();
    if (this.#state.phase === "capturing") await this.#nextPose({ skip: true });
  }

  async #undo() {
    await this.#queue.drained();
    if (this.#state.phase !== "capturing" || viewCount(this.#state) === 0) return;
    // What the service has, or is just being sent, only the service can take back.
    if (this.#state.away && (this.#state.sending || this.#queue.late || this.#session.lastIsTaken)) {
      return this.#tell({ type: "told", notice: { key: "capture.undo_away", kind: "plain" }, time: performance.now() });
    }
    await this.#queue.ask(
      () => this.#session.undo(),
      (session) => this.#tell({ type: "undone", session, stored: this.#session.stored(this.#state), time: performance.now() }),
    );
    await this.#nextPose();
  }

  /** What arrives after the run has ended is of no use to the next one. @param {Event} event */
  #tell(event) {
    if (!this.#signal.aborted) this.#page.dispatch(event);
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target instanceof Element && event.target.closest("input:not([type=checkbox]), select, textarea, [contenteditable]")) return;
    const key = event.key.toLowerCase();
    if (key === "u") void this.#undo();
    else if (key === "n") void this.#skip();
    else return;
    event.preventDefault();
  }
}
