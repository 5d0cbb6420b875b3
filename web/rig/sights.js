// Sights of the board in all cameras of this device, by their positions in the rig.
import { BLIND, aimAt, doubt, observeFrame } from "../lib/capture/sight.js";
import { isSeen } from "./moments.js";

/**
 * @import { Corners } from "../lib/board-outline.js"
 * @import { Sight } from "./moments.js"
 */

/**
 * @typedef {import("../lib/board.js").SentBoard} Board
 */

export class Sights {
  #board;
  /** Corners seen when a moment was opened, by position. @type {Map<number, Corners>} */
  #marked = new Map();
  /** @type {Map<number, Sight>} */
  all = new Map();

  /** @param {readonly {position: number, size: [number, number]}[]} cameras @param {Board} board */
  constructor(cameras, board) {
    this.#board = board;
    for (const { position, size } of cameras) this.all.set(position, { ...BLIND, size });
  }

  get list() {
    return [...this.all.values()];
  }

  /** @param {number} position @returns {Sight} */
  at(position) {
    return this.all.get(position) ?? BLIND;
  }

  /**
   * @param {number} position @param {import("../lib/detector.js").Detection} detection
   * @param {number} lenience how many times a steady hand's motion counts as still
   */
  observe(position, detection, lenience) {
    this.all.set(position, observeFrame(this.at(position), detection, performance.now(), this.#board, lenience));
  }

  /** @param {number} position @param {import("../lib/board-recognition.js").Recognised | null} suggestion */
  suggest(position, suggestion) {
    this.all.set(position, doubt(this.at(position), suggestion, this.#board, performance.now()));
  }

  /** Gives each camera its target, or none. @param {readonly import("./service.js").Target[]} targets */
  aim(targets) {
    for (const [position, sight] of this.all) {
      const target = targets.find((each) => each.position === position) ?? null;
      this.all.set(position, aimAt(sight, target, this.#board));
    }
  }

  /** Notes what each camera sees now, while a moment is opened. */
  mark() {
    this.#marked = new Map(
      [...this.all].filter(([, sight]) => isSeen(sight)).map(([position, { corners }]) => [position, corners]),
    );
  }

  /** Counts what was seen when the moment was opened as taken. */
  take() {
    for (const [position, corners] of this.#marked)
      this.all.set(position, { ...this.at(position), lastTaken: corners });
  }

  /** Counts nothing as taken any more, after an undo. */
  forget() {
    for (const [position, sight] of this.all) this.all.set(position, { ...sight, lastTaken: null });
  }
}
