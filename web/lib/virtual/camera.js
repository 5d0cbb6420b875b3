// Virtual camera: a MediaStream that shows the board through a known lens, and follows the targets.
import { DEFAULT_BOARD, outline, sizeOf } from "../board.js";
import { Hand } from "./hand.js";
import { matchPose } from "./match.js";
import { labelOf } from "./setup.js";
import { FAULTS } from "./degrade.js";
import { Calibration } from "../../sdk/calibration.js";
import { intrinsicsOf } from "./lens.js";

/**
 * @import { Board } from "../board.js"
 * @import { Pose } from "../pose.js"
 * @import { LensParameters } from "./lens.js"
 * @import { Setup } from "./setup.js"
 */

const MIN_REFRESH_INTERVAL_MS = 50; // ms; a canvas delivers frames only when it is painted

export class VirtualCamera {
  #canvas;
  #context;
  #worker;
  #setup;
  #hand;
  #board;
  /** True while a picture is being painted, or about to be. */
  #asked = false;
  /** Time of the last request for a picture, ms. */
  #askedAt = -Infinity;
  /** True once the last picture of a hand that does not move has been requested. */
  #settled = false;
  /** @type {ImageData | null} */
  #picture = null;
  /** @type {Pose | null} of the board while it is held, without the motion of a hand */
  #held = null;
  /** @type {Pose | null} of the board in the picture that is being painted */
  #painted = null;
  /** @type {Pose | null} of the board in the picture on the canvas */
  #shown = null;
  /** @type {ReturnType<typeof setInterval> | undefined} */
  #timer;
  /** @type {ReturnType<typeof setTimeout> | undefined} of the next picture */
  #next;
  /** @type {MediaStream | null} */
  #stream = null;

  /**
   * @param {Setup} setup
   * @param {HTMLElement} place a canvas must be in the document to deliver frames
   * @param {Board} [board]
   */
  constructor(setup, place, board = DEFAULT_BOARD) {
    this.#setup = setup;
    this.#board = board;
    this.#canvas = place.ownerDocument.createElement("canvas");
    [this.#canvas.width, this.#canvas.height] = setup.size;
    this.#canvas.className = "virtual-camera";
    this.#canvas.setAttribute("aria-hidden", "true");
    place.append(this.#canvas);
    const context = this.#canvas.getContext("2d", { alpha: false });
    if (!context) throw new Error("this browser has no 2D canvas");
    this.#context = context;
    this.#worker = new Worker(new URL("./painter-worker.js", import.meta.url), { type: "module" });
    const [columns, rows] = sizeOf(board);
    const [left, top] = outline(board)[0];
    const [x, y] = [left + columns / 2, top + rows / 2];
    const distance = ((1.6 * columns * setup.lens.fx) / setup.size[0]) * (setup.shown.distance ?? 1);
    this.#hand = new Hand(setup.hand, {
      error: setup.error,
      seed: setup.seed,
      pivot: [x, y, 0],
      focal: (setup.lens.fx * 1280) / setup.size[0],
      start: { rvec: [0, 0, 0], tvec: [-x, -y, distance] },
    });
  }

  get label() {
    return labelOf(this.#setup);
  }

  /** Canvas on which the pictures are painted. */
  get canvas() {
    return this.#canvas;
  }

  /** Pose of the board in the picture on the canvas; null before the first. */
  get shown() {
    return this.#shown;
  }

  /** @returns {Promise<MediaStream>} */
  async open() {
    const {
      lens,
      size,
      rate,
      fault,
      shown: { distance, ...shown },
    } = this.#setup;
    const board = { ...this.#board, ...shown };
    await new Promise((resolve, reject) => {
      this.#worker.onmessage = resolve;
      this.#worker.onerror = (event) => reject(new Error(event.message || "the virtual camera could not start"));
      this.#worker.postMessage({ open: { board, lens, size, fault: FAULTS.includes(fault) ? fault : "" } });
    });
    this.#worker.onmessage = ({ data }) => this.#show(data.picture);
    const stream = streamOf(this.#canvas, rate, this.label);
    const [track] = stream.getVideoTracks();
    track.addEventListener("ended", () => this.close());
    this.#stream = stream;
    this.#ask();
    this.#timer = setInterval(() => this.#refresh(), Math.max(MIN_REFRESH_INTERVAL_MS, 1000 / rate));
    return stream;
  }

  /**
   * Moves the board to where it covers the target, as well as the hand can.
   * @param {Pose & {ids?: readonly number[], corners?: readonly (readonly number[])[]}} target board → camera, squares
   */
  follow(target) {
    const { rvec, tvec } = matchPose(this.#board, this.#setup.lens, target);
    const distance = this.#setup.shown.distance ?? 1;
    this.#hand.follow({ rvec, tvec: [tvec[0], tvec[1], tvec[2] * distance] }, performance.now());
    this.#settled = false;
    if (!this.#asked) this.#ask();
  }

  /** Holds the board exactly in this pose. @param {Pose} pose board → camera, squares */
  hold(pose) {
    this.#held = pose;
    this.#settled = false;
    if (!this.#asked) this.#ask();
  }

  close() {
    clearInterval(this.#timer);
    clearTimeout(this.#next);
    this.#worker.terminate();
    for (const track of this.#stream?.getTracks() ?? []) track.stop();
    this.#canvas.remove();
  }

  #ask() {
    const now = performance.now();
    this.#settled = this.#held !== null || !this.#hand.moves(now);
    this.#asked = true;
    this.#askedAt = now;
    this.#painted = this.#held ?? this.#hand.pose(now);
    this.#worker.postMessage({ pose: this.#painted, blur: this.#held ? 0 : this.#hand.blur() });
  }

  /** @param {ImageData} picture */
  #show(picture) {
    this.#picture = picture;
    this.#shown = this.#painted;
    this.#context.putImageData(picture, 0, 0);
    this.#asked = !this.#settled;
    if (!this.#settled)
      this.#next = setTimeout(() => this.#ask(), this.#askedAt + 1000 / this.#setup.rate - performance.now());
  }

  #refresh() {
    // One pixel in its own colour: enough for the stream to deliver the picture again.
    if (this.#picture && this.#settled) this.#context.putImageData(this.#picture, 0, 0, 0, 0, 1, 1);
  }
}

/**
 * Stream of what is painted on a canvas, with the label and the settings of a camera.
 * @param {HTMLCanvasElement} canvas @param {number} rate Hz @param {string} label
 */
export function streamOf(canvas, rate, label) {
  const stream = canvas.captureStream(rate);
  const [track] = stream.getVideoTracks();
  const settings = { width: canvas.width, height: canvas.height, frameRate: rate, resizeMode: "none" };
  Object.defineProperty(track, "label", { value: label });
  Object.defineProperty(track, "getSettings", { value: () => settings });
  return stream;
}

/**
 * Ground truth: the calibration that a virtual camera renders with: practice needs no database.
 * @param {Setup} setup
 */
export function trueCalibration({ size, lens }) {
  return new Calibration(
    /** @type {import("../../sdk/calibration.js").CalibrationData} */ ({ img_size: size, ...intrinsicsOf(lens) }),
  );
}
