// Virtual camera: a MediaStream that shows the board through a known lens, and follows the targets.
import { DEFAULT_BOARD, outline, sizeOf } from "../board.js";
import { HANDS, Hand } from "./hand.js";
import { matchPose } from "./match.js";
import { NAME, isVirtual } from "./name.js";
import { FAULTS } from "./degrade.js";

export { isVirtual };

/**
 * @typedef {import("../board.js").Board} Board
 * @typedef {import("./lens.js").LensParameters} LensParameters
 * @typedef {import("../pose.js").Pose} Pose
 *
 * @typedef {object} Setup
 * @property {[number, number]} size px
 * @property {LensParameters} lens
 * @property {number} error how clumsy the hand is: 0 not at all, 1 about 3° and 3 % of the distance
 * @property {number} seed of the hand
 * @property {string} hand whose it is, of `HANDS`
 * @property {string} fault what is wrong with the picture, of `FAULTS`; "" for nothing
 * @property {{legacy?: boolean, dictionary?: string, distance?: number}} shown how the board differs from the one asked for;
 *   distance: how many times as far away as asked for
 */

const FRAME_INTERVAL_MS = 50; // ms; a canvas that nobody paints on delivers no frames

/**
 * The camera that an address asks for: `img_size=1280x720`, `fx fy cx cy` in px, `k1 k2 p1 p2 k3`; the hand, `error seed
 * hand`; what is wrong, `fault shown_legacy shown_dictionary shown_distance`.
 * @param {URLSearchParams} parameters
 * @returns {Setup}
 */
export function setupFrom(parameters) {
  const [, w, h] = /^(\d{2,4})x(\d{2,4})$/.exec(parameters.get("img_size") ?? "") ?? ["", "1280", "720"];
  const [width, height] = [Number(w), Number(h)];
  /** @param {string} name @param {number} otherwise */
  const number = (name, otherwise) => {
    const text = parameters.get(name);
    const value = Number(text);
    return text && Number.isFinite(value) ? value : otherwise;
  };
  /** @param {string} name @param {string[]} known @param {string} otherwise */
  const named = (name, known, otherwise) => known.find((each) => each === parameters.get(name)) ?? otherwise;
  const fx = number("fx", 0.8 * width);
  return {
    size: [width, height],
    lens: {
      fx,
      fy: number("fy", fx),
      cx: number("cx", (width - 1) / 2 + 0.012 * width),
      cy: number("cy", (height - 1) / 2 - 0.012 * width),
      k1: number("k1", -0.2),
      k2: number("k2", 0.04),
      p1: number("p1", 0),
      p2: number("p2", 0),
      k3: number("k3", 0),
    },
    error: number("error", 1),
    seed: number("seed", 1),
    hand: named("hand", Object.keys(HANDS), "still"),
    fault: named("fault", FAULTS, ""),
    shown: {
      ...(parameters.has("shown_legacy") && { legacy: parameters.get("shown_legacy") === "true" }),
      ...(parameters.has("shown_dictionary") && { dictionary: parameters.get("shown_dictionary") ?? "" }),
      distance: number("shown_distance", 1),
    },
  };
}

/** The name it reports: another lens is another camera. @param {Setup} setup */
export function labelOf({ size, lens }) {
  const text = JSON.stringify([size, ...Object.entries(lens).flat()]);
  let hash = 0x811c9dc5; // FNV-1a
  for (const character of text) hash = Math.imul(hash ^ character.charCodeAt(0), 0x01000193) >>> 0;
  return `${NAME} ${hash.toString(16).padStart(8, "0")}`;
}

export class VirtualCamera {
  #canvas;
  #context;
  #worker;
  #setup;
  #hand;
  #board;
  /** Is a picture being painted? */
  #asked = false;
  /** Has the last picture of a hand that does not move been asked for? */
  #settled = false;
  /** @type {ImageData | null} */
  #picture = null;
  /** @type {Pose | null} in which somebody holds the board, without a hand */
  #held = null;
  /** @type {Pose | null} of the board in the picture that is being painted */
  #painted = null;
  /** @type {Pose | null} of the board in the picture on the canvas */
  #shown = null;
  /** @type {ReturnType<typeof setInterval> | undefined} */
  #timer;
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
      error: setup.error, seed: setup.seed, pivot: [x, y, 0],
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
    const { lens, size, fault, shown: { distance, ...shown } } = this.#setup;
    const board = { ...this.#board, ...shown };
    await new Promise((resolve, reject) => {
      this.#worker.onmessage = resolve;
      this.#worker.onerror = (event) => reject(new Error(event.message || "the virtual camera could not start"));
      this.#worker.postMessage({ open: { board, lens, size, fault } });
    });
    this.#worker.onmessage = ({ data }) => this.#show(data.picture);
    const stream = this.#canvas.captureStream(30);
    const [track] = stream.getVideoTracks();
    Object.defineProperty(track, "label", { value: this.label });
    const settings = { width: size[0], height: size[1], frameRate: 30, resizeMode: "none" };
    Object.defineProperty(track, "getSettings", { value: () => settings });
    track.addEventListener("ended", () => this.close());
    this.#stream = stream;
    this.#ask();
    this.#timer = setInterval(() => this.#refresh(), FRAME_INTERVAL_MS);
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

  /** Holds the board in this very pose. @param {Pose} pose board → camera, squares */
  hold(pose) {
    this.#held = pose;
    this.#settled = false;
    if (!this.#asked) this.#ask();
  }

  close() {
    clearInterval(this.#timer);
    this.#worker.terminate();
    for (const track of this.#stream?.getTracks() ?? []) track.stop();
    this.#canvas.remove();
  }

  #ask() {
    const now = performance.now();
    this.#settled = this.#held !== null || !this.#hand.moves(now);
    this.#asked = true;
    this.#painted = this.#held ?? this.#hand.pose(now);
    this.#worker.postMessage({ pose: this.#painted, blur: this.#held ? 0 : this.#hand.blur() });
  }

  /** @param {ImageData} picture */
  #show(picture) {
    this.#picture = picture;
    this.#shown = this.#painted;
    this.#context.putImageData(picture, 0, 0);
    this.#asked = false;
    if (!this.#settled) this.#ask();
  }

  #refresh() {
    // One pixel in its own colour: enough for the stream to deliver the picture again.
    if (this.#picture && this.#settled) this.#context.putImageData(this.#picture, 0, 0, 0, 0, 1, 1);
  }
}
