// The loop of one capture: looks, sends what is held still, follows the targets.
import { lockFocus } from "./camera.js";
import { grab } from "./detector.js";
import { decide, isOfSize } from "./state.js";
import { motion } from "./stillness.js";

/**
 * @typedef {import("./state.js").Event} Event
 *
 * @typedef {object} Page what a capture needs of the page that it runs in
 * @property {import("./render.js").Parts} parts
 * @property {() => import("./state.js").State} state as it is now
 * @property {(event: Event) => void} dispatch
 * @property {(error: unknown, signal: AbortSignal) => void} fail
 *
 * @typedef {import("./session.js").CaptureSession} CaptureSession
 * @typedef {import("./detector.js").Detector} Detector
 * @typedef {import("./camera.js").OpenCamera} OpenCamera
 */

const STEADY = 3; // px between the hold's last frame and the one that is sent, at 1280 px width
const FOCUSED = 0.6; // part of the board's corners from which the lens is taken to be focused on it

/** The loop of one capture. */
export class Guide {
  #page;
  #session;
  #detector;
  #camera;
  #signal;
  #focused = false;
  /** The conversation with the service that is going on. */
  #talk = Promise.resolve();

  /** @param {Page} page @param {{session: CaptureSession, detector: Detector, camera: OpenCamera, signal: AbortSignal}} means */
  constructor(page, { session, detector, camera, signal }) {
    this.#page = page;
    this.#session = session;
    this.#detector = detector;
    this.#camera = camera;
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

  /** Looks at one frame after the other until the session has converged. */
  async run() {
    this.#nextPose();
    while (this.#state.phase === "capturing" && !this.#signal.aborted) {
      await nextFrame(this.#video);
      if (document.hidden || this.#signal.aborted) continue;
      const detection = await this.#detector.detect(await grab(this.#video));
      if (this.#signal.aborted) return;
      this.#tell({ type: "frame", detection, time: performance.now() });
      this.#focus();
      const action = decide(this.#state, performance.now());
      if (action === "submit") await this.#submit();
      else if (action === "skip") this.#nextPose({ skip: true });
    }
  }

  #focus() {
    const [columns, rows] = this.#state.board.squares;
    if (this.#focused || this.#state.corners.ids.length < FOCUSED * (columns - 1) * (rows - 1)) return;
    this.#focused = true;
    void lockFocus(this.#camera.track);
  }

  async #submit() {
    const { pose, key, corners } = this.#state;
    if (!pose || !key) return;
    const detection = await this.#detector.detect(await grab(this.#video), { full: true });
    const { ids, points, size } = detection;
    // Between the two frames the device may have been turned, or the hold may have ended.
    if (!isOfSize(size, key)) return this.#tell({ type: "frame", detection, time: performance.now() });
    const view = { ids, points };
    if (ids.length === 0 || motion(corners, view) > (STEADY * key.img_size[0]) / 1280) return;
    await this.#exclusive(async () => {
      const answer = await this.#session.submit(pose.index, view);
      this.#tell({ type: "answer", answer, corners: view, time: performance.now() });
    });
    if (this.#state.phase === "capturing" && !this.#state.pose) this.#nextPose();
  }

  /** @param {{skip?: boolean}} [options] */
  #nextPose(options) {
    return this.#exclusive(async () => {
      const { pose, picture } = await this.#session.pose(options);
      if (this.#signal.aborted) return;
      this.#tell({ type: "pose", pose, picture: URL.createObjectURL(picture), time: performance.now() });
      this.#camera.virtual?.follow(pose);
    });
  }

  async #skip() {
    await this.#silence();
    if (this.#state.phase === "capturing") await this.#nextPose({ skip: true });
  }

  async #undo() {
    await this.#silence();
    if (this.#state.phase !== "capturing" || !this.#state.session?.views.length) return;
    await this.#exclusive(async () => {
      this.#tell({ type: "undone", session: await this.#session.undo(), time: performance.now() });
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
    try {
      await action();
      this.#tell({ type: "idle" });
    } catch (error) {
      this.#page.fail(error, this.#signal);
    }
  }

  /** What a person asked for waits for its turn. */
  async #silence() {
    while (this.#state.busy && !this.#signal.aborted) await this.#talk;
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (event.repeat || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target instanceof Element && event.target.closest("input, select, textarea, [contenteditable]")) return;
    const key = event.key.toLowerCase();
    if (key === "u") void this.#undo();
    else if (key === "n") void this.#skip();
    else return;
    event.preventDefault();
  }
}

/** The next frame that the video shows. @param {HTMLVideoElement} video @returns {Promise<void>} */
function nextFrame(video) {
  return new Promise((resolve) => {
    // A camera that stalls, or a hidden tab, must not stop the loop for good.
    const timer = setTimeout(resolve, 500);
    const done = () => {
      clearTimeout(timer);
      resolve();
    };
    if (video.requestVideoFrameCallback) video.requestVideoFrameCallback(done);
    else requestAnimationFrame(done);
  });
}
