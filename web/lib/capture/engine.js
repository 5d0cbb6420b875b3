// Capture engine: looks at one frame after the other of one or more cameras, and takes views. The page says what a view
// is for: it keeps the sight of the board in each camera, and acts on what is due.
import { lockFocus } from "../camera.js";
import { DetectorError } from "../detector.js";
import { nextFrame } from "../frames.js";
import { isSettled } from "./sight.js";
import { motion } from "./stillness.js";

/**
 * @import { Corners } from "../board-outline.js"
 * @import { Detection, Detector } from "../detector.js"
 * @import { Stream } from "./streams.js"
 */

/**
 * @typedef {{stream: Stream, half: number}} Camera half: index of its image in the stream
 */

/**
 * @template {Camera} C
 * @typedef {object} Page what the engine needs of the page that it runs in
 * @property {() => boolean} isOver the capture has ended
 * @property {(camera: C) => import("./sight.js").Sight} sight of the board in the last frame
 * @property {(camera: C, detection: Detection, taken: number) => void} observe taken: ms for the frame
 * @property {() => Promise<void>} act does what is due after a frame of each camera
 * @property {(camera: C) => boolean} isSearched other boards are looked for while the expected one is not seen
 * @property {(camera: C, suggestion: import("../board-recognition.js").Recognised | null) => void} suggest
 *   suggestion: what is there instead of the board
 * @property {() => void} [onReturn] called when the tab is shown again
 * @property {(stalled: boolean) => void} onStalled called when the detector has stopped, and when another one is there
 * @property {() => void} onResized called when a device was turned: its images have another size
 * @property {(stream: Stream) => void} [onFocused] called when the focus is locked, if the camera allows it
 */

/**
 * @template {Camera} C
 * @typedef {object} Resources
 * @property {readonly C[]} cameras
 * @property {() => import("../board.js").SentBoard} board that is looked for
 * @property {() => Promise<Detector>} openDetector another one if the last has failed
 * @property {() => boolean} [isFlipped] images are mirrored, and are turned back
 * @property {AbortSignal} signal
 */

const MAX_MOTION_PX = 3; // between the last frame and the one that is taken, at 1280 px image width
const MIN_RELATIVE_SHARPNESS = 0.75; // of the last frames: less is one blurred frame, and the next one will do
const SHARPNESS_FRAMES = 12; // over which the median sharpness is taken
const MAX_RESTARTS = 3; // of the detector in one capture: a fourth would not help

/** @template {Camera} C */
export class Engine {
  #page;
  #resources;
  /** @type {Detector | null} */
  #detector = null;
  #restarts = 0;
  #wasHidden = false;
  #isSearching = false;
  /** Streams whose focus is locked. @type {Set<Stream>} */
  #focused = new Set();
  /** Sharpness of the last frames. @type {Map<C, number[]>} */
  #sharpness = new Map();
  /** Loaded when no corner is seen. @type {Map<C, import("./board-watch.js").BoardWatch>} */
  #watches = new Map();

  /** @param {Page<C>} page @param {Resources<C>} resources */
  constructor(page, resources) {
    this.#page = page;
    this.#resources = resources;
  }

  /** Runs until the capture has ended. */
  async run() {
    const { signal, openDetector } = this.#resources;
    this.#detector = await openDetector();
    while (!signal.aborted && !this.#page.isOver()) {
      if ((await this.#look()) && !signal.aborted) await this.#page.act();
    }
  }

  /** Looks at the next frame of each camera. @returns {Promise<boolean>} false: at least one was not looked at */
  async #look() {
    const { cameras, signal } = this.#resources;
    await nextFrame(cameras[0].stream.video);
    if (signal.aborted || this.#isHidden()) return false;
    for (const stream of new Set(cameras.map((camera) => camera.stream))) {
      if (!(await this.#lookAt(stream))) return false;
    }
    return true;
  }

  /** @param {Stream} stream */
  async #lookAt(stream) {
    const { cameras, signal } = this.#resources;
    if (!stream.unchanged) {
      this.#page.onResized();
      return false;
    }
    let began = performance.now();
    const images = await stream.grab();
    try {
      for (const camera of cameras.filter((each) => each.stream === stream)) {
        const detection = await this.#detect(images[camera.half]);
        if (!detection || signal.aborted) return false;
        this.#observe(camera, detection, performance.now() - began);
        began = performance.now();
      }
    } finally {
      for (const image of images) image.close();
    }
    return true;
  }

  /** True if the tab is hidden: then no board is in front of it. */
  #isHidden() {
    const hidden = document.hidden;
    if (this.#wasHidden && !hidden) this.#page.onReturn?.();
    this.#wasHidden = hidden;
    return hidden;
  }

  /** @param {C} camera @param {Detection} detection @param {number} taken ms */
  #observe(camera, detection, taken) {
    const sharpness = detection.metrics?.sharpness;
    if (sharpness) {
      const last = this.#sharpness.get(camera) ?? [];
      this.#sharpness.set(camera, [...last, sharpness].slice(-SHARPNESS_FRAMES));
    }
    this.#page.observe(camera, detection, taken);
    void this.#focus(camera);
    void this.#search(camera);
  }

  /**
   * Runs one image through the detector; null if the detector stopped and another one had to be made.
   * @param {VideoFrame | ImageBitmap} image is taken over
   * @param {{full?: boolean}} [options]
   */
  async #detect(image, options) {
    const { openDetector, isFlipped, signal } = this.#resources;
    const detector = this.#detector ?? (await openDetector());
    try {
      return await detector.detect(image, { ...options, flip: isFlipped?.() });
    } catch (error) {
      if (!(error instanceof DetectorError) || signal.aborted || ++this.#restarts > MAX_RESTARTS) throw error;
      console.info("the detector is restarted:", error.message);
    }
    this.#page.onStalled(true);
    detector.close();
    this.#detector = await openDetector();
    this.#page.onStalled(false);
    return null;
  }

  /**
   * Takes a view: a fresh frame, searched thoroughly, and refused if it is blurred or the hand has jerked since the
   * last one.
   * @param {C} camera
   * @param {{lenience?: () => number, isKept?: boolean}} [options] lenience: how many times a steady hand's motion
   *   counts as still; isKept: the image is returned as well
   * @returns {Promise<{corners: Corners, image: ImageBitmap | null} | null>} null: this frame will not do
   */
  async take(camera, { lenience = () => 1, isKept = false } = {}) {
    const { corners: before, size } = this.#page.sight(camera);
    const image = await this.#grab(camera);
    const kept = isKept ? await createImageBitmap(image) : null;
    const detection = await this.#detect(image, { full: true });
    if (detection && !this.#resources.signal.aborted) {
      const { ids, points } = detection;
      // Between the two frames the device may have turned.
      if (String(detection.size) !== String(size)) this.#page.onResized();
      else if (
        this.#isSharp(camera, detection) &&
        motion(before, { ids, points }) <= (MAX_MOTION_PX * size[0] * lenience()) / 1280
      )
        return { corners: { ids, points }, image: kept };
    }
    kept?.close();
    return null;
  }

  /** The camera's image now. @param {C} camera */
  async #grab({ stream, half }) {
    const images = await stream.grab();
    images.forEach((each, index) => index !== half && each.close());
    return images[half];
  }

  /** @param {C} camera @param {Detection} detection */
  #isSharp(camera, { metrics }) {
    const last = this.#sharpness.get(camera) ?? [];
    const usual = [...last].sort((a, b) => a - b)[last.length >> 1];
    return !metrics?.sharpness || !usual || metrics.sharpness >= MIN_RELATIVE_SHARPNESS * usual;
  }

  /** @param {C} camera */
  async #focus(camera) {
    const { stream } = camera;
    if (this.#focused.has(stream) || !isSettled(this.#page.sight(camera), this.#resources.board())) return;
    this.#focused.add(stream);
    await lockFocus(stream.camera.track);
    if (!this.#resources.signal.aborted) this.#page.onFocused?.(stream);
  }

  /**
   * Looks for another board if the expected one is not seen. The next frame reports a failure of the detector.
   * @param {C} camera
   */
  async #search(camera) {
    const { board, isFlipped, signal } = this.#resources;
    const { blindSince } = this.#page.sight(camera).diagnosis;
    const known = this.#watches.get(camera);
    // In any case: it forgets what it has seen as soon as the board is seen.
    const isDue = known ? known.isDue(blindSince, performance.now()) : blindSince !== Infinity;
    if (!isDue || this.#isSearching || !this.#page.isSearched(camera)) return;
    this.#isSearching = true;
    try {
      const watch = known ?? new (await import("./board-watch.js")).BoardWatch();
      this.#watches.set(camera, watch);
      if (!watch.isDue(blindSince, performance.now())) return;
      const sighting = await this.#detector?.sight(await this.#grab(camera), { flip: isFlipped?.() });
      if (sighting && !signal.aborted) this.#page.suggest(camera, watch.add(sighting, board(), performance.now()));
    } catch (error) {
      if (!(error instanceof DetectorError)) throw error;
    } finally {
      this.#isSearching = false;
    }
  }
}
