// Live pictures of a camera with a drawing over them. A picture is shown together with the detection in the same
// picture, so that the visible misalignment comes from the calibration, not from latency.
import { corners as boardCorners } from "../lib/board.js";
import { grab } from "../lib/detector.js";
import { nextFrame } from "../lib/frames.js";
import { housePoints } from "./house.js";
import { difference, misalignment } from "./misalignment.js";
import { model } from "./model.js";
import { MODES } from "./modes.js";
import { poseOf } from "../lib/board-pose.js";
import { RectifierError } from "../sdk/warp.js";
import { Scene } from "./scene.js";
import { lensOf } from "../sdk/projection.js";

/** @import { Calibration } from "../sdk/rectification.js" */

/**
 * @typedef {{rms: number, outermost: number} | null} Misalignment null: no board is seen
 *
 * @typedef {object} Setup
 * @property {HTMLVideoElement} video
 * @property {HTMLElement} layers where the pictures go
 * @property {import("../lib/board.js").Board} board
 * @property {import("../lib/detector.js").Detector} detector
 * @property {Calibration} calibration
 * @property {string} mode of `MODES`
 * @property {number} balance how much of the edge the straightened picture keeps, 0…1
 */

// ms that a browser has to give back what it drew with: a driver that is started again takes one or two
const RESTORE_TIMEOUT_MS = 5000;

export class Live {
  #setup;
  #mode;
  #balance;
  #places;
  #frame;
  #picture;
  #scene;
  #house;
  /** Camera that the mode `estimate` draws with; to be set before. @type {Calibration | null} */
  estimate = null;
  /** Made when first used. @type {Map<string, ReturnType<typeof MODES.matrix>>} */
  #made = new Map();
  /**
   * The last detection, for showing the same picture in another way.
   * @type {{points: number[][], pixels: number[][]}}
   */
  #last = { points: [], pixels: [] };

  /** @param {Setup} setup throws RectifierError where there is no WebGL2 */
  constructor(setup) {
    this.#setup = setup;
    this.#mode = setup.mode;
    this.#balance = setup.balance;
    this.#places = boardCorners(setup.board);
    this.#frame = paper(setup.calibration.img_size);
    this.#picture = paper(setup.calibration.img_size);
    this.#scene = new Scene(model(setup.board));
    this.#house = housePoints(...setup.board.squares);
  }

  /**
   * Detects and draws until the signal aborts.
   * @param {AbortSignal} signal @param {(off: Misalignment, mode: string) => void} onShown
   * @returns {Promise<"resized" | null>} resized: the camera's picture has another size than the calibration; rejects
   *   with a RectifierError if the GPU is lost and does not come back
   */
  async run(signal, onShown) {
    const { video, detector, calibration } = this.#setup;
    let drawn = performance.now();
    while (!signal.aborted) {
      await nextFrame(video);
      if (document.hidden) drawn = performance.now(); // where phones let go of it
      if (signal.aborted || document.hidden) continue;
      const frame = await grab(video);
      this.#frame.drawImage(frame, 0, 0);
      const { ids, points: pixels, size } = await detector.detect(frame, { full: true });
      if (signal.aborted) break;
      if (size.join() !== calibration.img_size.join()) return "resized";
      this.#picture.drawImage(this.#frame.canvas, 0, 0);
      this.#last = { points: ids.map((id) => this.#places[id]), pixels };
      onShown(this.#show(), this.#mode);
      if (!this.#lost) drawn = performance.now();
      else if (performance.now() - drawn > RESTORE_TIMEOUT_MS) throw new RectifierError("the GPU was lost", true);
    }
    return null;
  }

  /** Shows the same picture in another way at once. @param {string} name of `MODES` @returns {Misalignment} */
  mode(name) {
    this.#mode = name;
    return this.#show();
  }

  /** @param {number} value 0…1 @returns {Misalignment} */
  balance(value) {
    this.#balance = value;
    this.#made.get("rectified")?.balance?.(value);
    return this.#show();
  }

  dispose() {
    for (const each of this.#made.values()) each.dispose();
    this.#scene.dispose();
    this.#setup.layers.replaceChildren();
  }

  /** True if a canvas that is shown has lost its GPU context. */
  get #lost() {
    const { picture, overlay } = this.#modeNamed(this.#mode);
    return [this.#scene.canvas, picture, overlay].some((canvas) => canvas?.getContext("webgl2")?.isContextLost());
  }

  #show() {
    const { points, pixels } = this.#last;
    const { layers, calibration } = this.#setup;
    const mode = this.#modeNamed(this.#mode);
    const pose = poseOf(mode.lens, points, pixels);
    this.#scene.draw(mode.pinhole(), pose);
    mode.show(this.#picture.canvas, this.#scene.canvas);
    const [picture, overlay] = [mode.picture ?? this.#picture.canvas, mode.overlay ?? this.#scene.canvas];
    if (layers.firstChild !== picture || layers.lastChild !== overlay) layers.replaceChildren(picture, overlay);
    if (!pose || this.#mode !== "estimate")
      return pose && misalignment(mode, pose, points, pixels, calibration.img_size);
    const lens = lensOf(calibration);
    const calibrated = poseOf(lens, points, pixels);
    return calibrated && difference({ lens: mode.lens, pose }, { lens, pose: calibrated }, this.#house);
  }

  /** @param {string} name */
  #modeNamed(name) {
    const known = this.#made.get(name);
    if (known) return known;
    const made = MODES[name]((name === "estimate" && this.estimate) || this.#setup.calibration);
    made.balance?.(this.#balance);
    this.#made.set(name, made);
    return made;
  }
}

/** @param {[number, number]} size */
function paper([width, height]) {
  const canvas = Object.assign(document.createElement("canvas"), { width, height });
  const context = canvas.getContext("2d", { alpha: false });
  if (!context) throw new Error("this browser has no 2D canvas");
  return context;
}
