// The loop of one capture: looks, sends what is held still, follows the targets, and goes on when something fails.
import { ApiError } from "./api.js";
import { facts, lockFocus } from "./camera.js";
import { DetectorError, grab } from "./detector.js";
import { nextProbe } from "./diagnosis.js";
import { Pace, nextFrame } from "./frames.js";
import { decide, isSettled, lenience } from "./hold.js";
import { nextPlanned, trusted } from "./plan.js";
import { isAway, isEnough, viewCount } from "./session.js";
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
 * @typedef {import("./session.js").CaptureSession} CaptureSession
 * @typedef {import("./detector.js").Detector} Detector
 * @typedef {import("./camera.js").OpenCamera} OpenCamera
 */

const STEADY = 3; // px between the hold's last frame and the one that is sent, at 1280 px width
const CRISP = 0.75; // of the sharpness that the hold's frames had: less is one blurred frame, and the next one will do
const REMEMBERED = 12; // frames
const RESTARTS = 3; // of the detector in one capture: a fourth would not help
const RECONNECT = [1, 2, 3, 4, 5]; // s between attempts; the last one again and again

/** The loop of one capture. */
export class Guide {
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
  /** The conversation with the service that is going on. */
  #talk = Promise.resolve();

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
    if (this.#state.away) this.#alone();
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
      if (detection.signs?.sharpness) this.#sharpness = [...this.#sharpness, detection.signs.sharpness].slice(-REMEMBERED);
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
    await this.#silence();
    if (this.#signal.aborted) return;
    this.#session.track(track);
    const { phase, session, away } = this.#state;
    if (phase !== "capturing" || (session && (away || viewCount(this.#state) > 0))) return;
    this.#tell({ type: "request", request: this.#session.request });
    if (!session) return; // it is begun once the service is there
    await this.#exclusive(async () => this.#tell({ type: "session", session: await this.#session.start() }));
    if (this.#state.phase === "capturing") await this.#nextPose();
  }

  async #submit() {
    const { pose, key, corners } = this.#state;
    if (!pose || !key) return;
    const detection = await this.#look({ full: true });
    if (!detection || this.#signal.aborted) return;
    const { ids, points, size, signs } = detection;
    // Between the two frames the device may have been turned, the hold may have ended, the hand may have jerked.
    if (!isOfSize(size, key)) return this.#tell({ type: "frame", detection, time: performance.now() });
    const usual = [...this.#sharpness].sort((a, b) => a - b)[this.#sharpness.length >> 1];
    if (signs?.sharpness && usual && signs.sharpness < CRISP * usual) return;
    const view = { ids, points };
    const steady = (STEADY * key.img_size[0] * lenience(this.#state, performance.now())) / 1280;
    if (ids.length === 0 || motion(corners, view) > steady) return;
    if (this.#state.away) {
      this.#session.keep(view);
      this.#tell({ type: "stored", corners: view, stored: this.#stored, time: performance.now() });
    } else {
      await this.#exclusive(async () => {
        const answer = await this.#session.submit(pose.index, view);
        this.#tell({ type: "answer", answer, corners: view, time: performance.now() });
      });
    }
    if (this.#state.phase === "capturing" && !this.#state.pose) void this.#nextPose();
  }

  /** @param {{skip?: boolean}} [options] */
  #nextPose(options) {
    if (this.#state.away) return Promise.resolve(this.#planPose());
    return this.#exclusive(async () => {
      const { pose, picture } = await this.#session.pose(options);
      const tinted = await tint(picture);
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
    await this.#silence();
    if (this.#state.phase === "capturing") await this.#nextPose({ skip: true });
  }

  async #undo() {
    await this.#silence();
    if (this.#state.phase !== "capturing" || viewCount(this.#state) === 0) return;
    // What the service has, or is just being sent, only the service can take back.
    if (this.#state.away && (this.#state.sending || this.#session.lastIsTaken)) {
      return this.#tell({ type: "told", notice: { key: "capture.undo_away", kind: "plain" }, time: performance.now() });
    }
    await this.#exclusive(async () => {
      const session = await this.#session.undo();
      this.#tell({ type: "undone", session, stored: this.#stored, time: performance.now() });
    });
    await this.#nextPose();
  }

  /** What arrives after the run has ended is of no use to the next one. @param {Event} event */
  #tell(event) {
    if (!this.#signal.aborted) this.#page.dispatch(event);
  }

  /** One conversation with the service at a time; what the page does by itself does not queue. @param {() => Promise<void>} action */
  #exclusive(action) {
    if (!this.#state.busy) this.#talk = this.#converse(action);
    return this.#talk;
  }

  /** @param {() => Promise<void>} action */
  async #converse(action) {
    this.#tell({ type: "busy" });
    const { restored } = this.#session;
    try {
      await action();
      this.#tell({ type: "idle" });
      if (this.#session.restored > restored) await this.#begunAnew();
    } catch (error) {
      if (this.#signal.aborted) return;
      if (isAway(error)) this.#goAway();
      else if (error instanceof ApiError && error.status === 409) await this.#agree();
      else this.#page.fail(error, this.#signal);
    }
  }

  /** How many of its views the new session took, it alone knows. */
  async #begunAnew() {
    this.#tell({ type: "session", session: (await this.#session.resume()).state });
    this.#tell({ type: "told", notice: { key: "capture.begun_anew", kind: "plain" }, time: performance.now() });
  }

  /** The service is of another mind about the session, after a lost answer: what it says holds. */
  async #agree() {
    try {
      const { state } = await this.#session.resume();
      this.#tell({ type: "session", session: state });
      this.#tell({ type: "idle" });
      if (this.#state.phase === "capturing") setTimeout(() => void this.#nextPose(), 0);
    } catch (error) {
      if (isAway(error)) this.#goAway();
      else this.#page.fail(error, this.#signal);
    }
  }

  /** Views that the service is not known to have. */
  get #stored() {
    return this.#state.session ? this.#session.waiting : this.#session.size;
  }

  #goAway() {
    if (this.#state.away) return this.#tell({ type: "idle" });
    this.#tell({ type: "away", stored: this.#stored, time: performance.now() });
    this.#alone();
  }

  /** Without the service: targets from the plan, views kept, and asking every now and then. */
  #alone() {
    this.#planPose();
    void this.#reconnect();
  }

  async #reconnect() {
    let [taken, refused] = [0, 0];
    for (let attempt = 0; !this.#signal.aborted; attempt++) {
      await new Promise((resolve) => setTimeout(resolve, 1000 * (RECONNECT[attempt] ?? RECONNECT[RECONNECT.length - 1])));
      if (this.#signal.aborted) return;
      try {
        const sent = await this.#session.resume(undefined, { onSending: () => this.#tell({ type: "sending", sending: true }) });
        [taken, refused] = [taken + sent.taken, refused + sent.refused];
        if (this.#session.waiting > 0 && sent.state.status !== "converged") continue; // taken while these were sent
        this.#tell({ type: "back", session: sent.state, taken, refused, time: performance.now() });
        break;
      } catch (error) {
        if (!isAway(error)) return this.#page.fail(error, this.#signal);
        this.#tell({ type: "sending", sending: false });
      }
    }
    if (this.#state.phase === "capturing") await this.#nextPose();
  }

  /** What a person asked for waits for its turn. */
  async #silence() {
    while (this.#state.busy && !this.#signal.aborted) await this.#talk;
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
