// Watch over the board in all cameras of this device, one frame after the other.
import { lockFocus } from "../lib/camera.js";
import { nextProbe } from "../lib/capture/diagnosis.js";
import { DetectorError } from "../lib/detector.js";
import { nextFrame } from "../lib/frames.js";
import { ResizeError } from "./model.js";
import { BLIND, aimAt, observeFrame } from "../lib/capture/sight.js";
import { isSeen } from "./moments.js";
import { motion } from "../lib/capture/stillness.js";

/**
 * @typedef {import("./model.js").Member} Member
 * @typedef {import("./moments.js").Sight} Sight
 * @typedef {import("../lib/board-outline.js").Corners} Corners
 *
 * @typedef {object} Options
 * @property {readonly Member[]} members
 * @property {import("../lib/board.js").SentBoard} board
 * @property {import("../lib/detector.js").Detector} detector
 * @property {AbortSignal} signal
 * @property {(error: unknown) => void} onFailure
 */

export class Watch {
  #options;
  /** Streams whose focus is locked. */
  #focused = new Set();
  /**
   * Corners seen when a moment was opened, by position.
   * @type {Map<number, Corners>}
   */
  #marked = new Map();
  /** By position. @type {Map<number, Sight>} */
  sights = new Map();

  /** @param {Options} options */
  constructor(options) {
    this.#options = options;
    for (const { position, size } of options.members) this.sights.set(position, { ...BLIND, size });
  }

  /**
   * Looks at the next frame of each camera.
   * @param {number} lenience how many times a steady hand's motion counts as still
   * @returns {Promise<boolean>} whether anything was looked at
   */
  async look(lenience) {
    const { members, signal, onFailure } = this.#options;
    await nextFrame(members[0].stream.video);
    if (signal.aborted || document.hidden) return false;
    for (const stream of new Set(members.map((member) => member.stream))) {
      if (!stream.unchanged) {
        onFailure(new ResizeError());
        return false;
      }
      const pictures = await stream.grab();
      for (const member of members)
        if (member.stream === stream) await this.#observe(member, pictures[member.half], lenience);
      if (signal.aborted) return false;
    }
    return true;
  }

  /** @param {Member} member @param {VideoFrame | ImageBitmap} picture @param {number} lenience */
  async #observe({ position, stream }, picture, lenience) {
    const detection = await this.detect(picture, {
      probe: nextProbe(this.sight(position).diagnosis, performance.now()),
    });
    if (!detection) return;
    const sight = observeFrame(this.sight(position), detection, performance.now(), this.#options.board, lenience);
    this.sights.set(position, sight);
    if (sight.stillness.held > 0 && isSeen(sight) && !this.#focused.has(stream)) {
      this.#focused.add(stream);
      void lockFocus(stream.camera.track);
    }
  }

  /** @param {VideoFrame | ImageBitmap} picture @param {{full?: boolean, probe?: string | null}} options */
  async detect(picture, options) {
    const { detector, signal, onFailure } = this.#options;
    try {
      return await detector.detect(picture, options);
    } catch (error) {
      if (signal.aborted) return null;
      if (!(error instanceof DetectorError)) throw error;
      onFailure(error);
      return null;
    }
  }

  /** @param {number} position @returns {Sight} */
  sight(position) {
    return this.sights.get(position) ?? BLIND;
  }

  /** Gives each camera its target, or none. @param {readonly import("./service.js").Target[]} targets */
  aim(targets) {
    for (const { position } of this.#options.members) {
      const target = targets.find((each) => each.position === position) ?? null;
      this.sights.set(position, aimAt(this.sight(position), target, this.#options.board));
    }
  }

  /** Notes what each camera sees now, while a moment is opened. */
  mark() {
    this.#marked = new Map(
      [...this.sights].filter(([, sight]) => isSeen(sight)).map(([position, { corners }]) => [position, corners]),
    );
  }

  /** Counts what was seen when the moment was opened as taken. */
  take() {
    for (const [position, corners] of this.#marked)
      this.sights.set(position, { ...this.sight(position), lastTaken: corners });
  }

  /** Counts nothing as taken any more, after an undo. */
  forget() {
    for (const [position, sight] of this.sights) this.sights.set(position, { ...sight, lastTaken: null });
  }
}

const MAX_MOTION_PX = 3; // between the last frame and the one that is taken, at 1280 px width

/**
 * View of a moment in one camera: a fresh frame, searched thoroughly, and refused if the hand has jerked since.
 * @param {import("./streams.js").Stream} stream @param {number} half index of the camera's picture in the stream
 * @param {Sight} sight of the board in the last frame
 * @param {(picture: VideoFrame | ImageBitmap) => Promise<import("../lib/detector.js").Detection | null>} detect takes
 *   the picture over
 * @returns {Promise<{corners: Corners, picture: ImageBitmap} | null>} null: this frame will not do
 */
export async function takeView(stream, half, sight, detect) {
  const pictures = await stream.grab();
  pictures.forEach((each, index) => index !== half && each.close());
  const picture = await createImageBitmap(pictures[half]);
  const detection = await detect(pictures[half]);
  const corners = detection && { ids: detection.ids, points: detection.points };
  if (corners && motion(sight.corners, corners) <= (MAX_MOTION_PX * sight.size[0]) / 1280) return { corners, picture };
  picture.close();
  return null;
}
