// Recognition of an unknown board in files: the page searches a few pictures, and asks one question.
import { isTelling, recognise } from "../lib/board-recognition.js";
import { boardWords } from "../lib/board-text.js";
import { el, part, liveRegion } from "../lib/dom.js";
import { t } from "../lib/i18n.js";
import { mark, thumbnail } from "./card.js";
import { UnreadableError, shots } from "./files.js";

/**
 * @import { Recognised, Sighting } from "../lib/board-recognition.js"
 * @import { SentBoard } from "../lib/board.js"
 * @import { Detector } from "../lib/detector.js"
 */

/**
 * @typedef {Recognised & {image: HTMLCanvasElement}} Shown image: a picture with
 *   its corners
 */

// to search: each may show other rows, and a board may appear late in a video
const MAX_PICTURES = 8;
const ENOUGH = 4; // pictures that show a board: more would say the same
const TIMEOUT_MS = 120_000; // ms for one picture, which may have a hundred times the pixels of a frame

/**
 * The board that the files show.
 * @param {Detector} detector @param {File[]} files @param {AbortSignal} signal
 * @returns {Promise<Shown | null>}
 */
export async function recogniseIn(detector, files, signal) {
  /** @type {Sighting[]} */
  const sightings = [];
  /** @type {HTMLCanvasElement[]} */
  const images = [];
  for await (const shot of samples(files, signal)) {
    if (signal.aborted) return null;
    const small = thumbnail(shot);
    const sighting = await detector.sight(shot, { timeout: TIMEOUT_MS });
    sightings.push(sighting);
    const [width] = sighting.size;
    const points = isTelling(sighting)
      ? sighting.markers.flatMap(({ corners }) => corners)
      : (sighting.chessboard?.points ?? []);
    mark(small, sighting.mirrored ? points.map(([x, y]) => [width - 1 - x, y]) : points, width);
    images.push(small);
    if (sightings.filter((each) => each.chessboard?.isPlain || isTelling(each)).length === ENOUGH) break;
  }
  const found = recognise(sightings);
  return found && { ...found, image: images[found.picture] };
}

/**
 * Pictures from all files, in an order that soon covers many of them.
 * @param {File[]} files
 * @param {AbortSignal} signal
 * @returns {AsyncGenerator<ImageBitmap | VideoFrame>}
 */
async function* samples(files, signal) {
  const count = Math.min(MAX_PICTURES, files.length);
  for (let index = 0; index < count && !signal.aborted; index++) {
    const file = files[Math.floor(((index + 0.5) * files.length) / count)];
    try {
      // A single video gives as many frames as several photos would.
      for await (const { picture } of shots(file, signal, { samples: Math.ceil(MAX_PICTURES / count) })) yield picture;
    } catch (error) {
      if (!(error instanceof UnreadableError)) throw error; // is reported after all files
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
    for (const [id, isRight] of /** @type {[string, boolean][]} */ ([
      ["use-board", true],
      ["other-board", false],
    ])) {
      part(id, HTMLButtonElement).addEventListener("click", () => this.#answer?.(isRight));
    }
  }

  /**
   * @param {Shown} shown
   * @param {AbortSignal} signal
   * @returns {Promise<boolean>} whether it is the board; false once aborted
   */
  ask({ board, image, mirrored, isCut }, signal) {
    part("question-picture", HTMLElement).replaceChildren(el("div", { class: "frame" }, image));
    const question = () => t(mirrored ? "photos.looks_mirrored" : "photos.looks_like", { board: boardWords(board) });
    this.#say(() => [question(), isCut && t("photos.board_cut")].filter(Boolean).join(" "));
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
