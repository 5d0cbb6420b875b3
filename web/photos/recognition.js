// The board in files of which nobody said what board they show: a few pictures are looked at, and one question is asked.
import { isTelling, recognise } from "../lib/board-recognition.js";
import { el, part } from "../lib/dom.js";
import { liveRegion } from "../lib/live-region.js";
import { t } from "../lib/i18n.js";
import { boardWords } from "../lib/board-form.js";
import { thumbnail } from "./card.js";
import { UnreadableError, shots } from "./files.js";

/**
 * @typedef {import("../lib/board.js").SentBoard} SentBoard
 * @typedef {import("../lib/detector.js").Detector} Detector
 * @typedef {import("../lib/board-recognition.js").Sighting} Sighting
 * @typedef {{board: SentBoard, picture: HTMLCanvasElement}} Recognised
 */

const MAX_PICTURES = 4; // that are looked at: rows that one does not show another does
const MAX_INVERTED = 2; // pictures in which white markers are looked for, where there are no black ones
const TIMEOUT_MS = 120_000; // ms for one picture, which may have a hundred times the pixels of a frame
const PICTURE_WIDTH = 480; // px

/**
 * The board that the files show.
 * @param {Detector} detector @param {File[]} files @param {AbortSignal} signal
 * @returns {Promise<Recognised | null>}
 */
export async function recogniseIn(detector, files, signal) {
  /** @type {Sighting[]} */
  const sightings = [];
  /** @type {HTMLCanvasElement[]} */
  const pictures = [];
  for (const inverted of [false, true]) {
    for await (const shot of samples(files, inverted ? MAX_INVERTED : MAX_PICTURES, signal)) {
      if (signal.aborted) return null;
      const small = await createImageBitmap(shot, { resizeWidth: Math.min(shot.width, PICTURE_WIDTH), resizeQuality: "high" });
      const families = sightings.flatMap(({ family }) => family ?? []);
      const sighting = await detector.sight(shot, { families, inverted: inverted || sightings.some((each) => each.inverted), timeout: TIMEOUT_MS });
      sightings.push(sighting);
      const scale = small.width / sighting.size[0];
      const points = isTelling(sighting) ? sighting.markers.flatMap(({ corners }) => corners) : sighting.chessboard?.points ?? [];
      pictures.push(thumbnail(small, points.map(([x, y]) => [(x + 0.5) * scale - 0.5, (y + 0.5) * scale - 0.5])));
      small.close();
    }
    const plain = sightings.some(({ chessboard }) => chessboard?.isPlain);
    if (plain || sightings.some(isTelling)) break;
  }
  const found = recognise(sightings.filter((each) => each.family !== null || each.chessboard?.isPlain));
  if (!found) return null;
  const shown = sightings.filter((each) => each.family !== null || each.chessboard?.isPlain)[found.picture];
  return { board: found.board, picture: pictures[sightings.indexOf(shown)] };
}

/** Pictures from all over the files. @param {File[]} files @param {number} most @param {AbortSignal} signal @returns {AsyncGenerator<ImageBitmap>} */
async function* samples(files, most, signal) {
  const count = Math.min(most, files.length);
  for (let index = 0; index < count && !signal.aborted; index++) {
    const file = files[Math.floor(((index + 0.5) * files.length) / count)];
    try {
      // Of a single video as many frames as of several photographs.
      for await (const { picture } of shots(file, signal, Math.ceil(most / count))) yield picture;
    } catch (error) {
      if (!(error instanceof UnreadableError)) throw error; // is told when all are read
    }
  }
}

/** Section that asks whether this is the board. */
export class BoardQuestion {
  #section = part("question", HTMLElement);
  #say = liveRegion(part("question-text", HTMLElement));
  /** @type {((isRight: boolean) => void) | null} */
  #answer = null;

  constructor() {
    for (const [id, isRight] of /** @type {[string, boolean][]} */ ([["use-board", true], ["other-board", false]])) {
      part(id, HTMLButtonElement).addEventListener("click", () => this.#answer?.(isRight));
    }
  }

  /** @param {Recognised} recognised @param {AbortSignal} signal @returns {Promise<boolean>} whether it is the board; false once aborted */
  ask({ board, picture }, signal) {
    part("question-picture", HTMLElement).replaceChildren(el("div", { class: "frame" }, picture));
    this.#say(() => t("photos.looks_like", { board: boardWords(board) }));
    this.#section.hidden = false;
    part("use-board", HTMLButtonElement).focus();
    return new Promise((resolve) => {
      this.#answer = (isRight) => {
        this.#answer = null;
        this.#section.hidden = true;
        resolve(isRight);
      };
      signal.addEventListener("abort", () => this.#answer?.(false));
    });
  }
}
