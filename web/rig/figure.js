// Picture of one camera of this device: its video, the target's outline and the corners seen, a line of words below.
import { drawBoard, drawTarget, visibleShare } from "../lib/capture/marks.js";
import { el, make, write } from "../lib/dom.js";

/** @import { Sight } from "./moments.js" */

const FLASH_MS = 900;

export class Figure {
  #parts;
  #stage;
  #marks;
  #caption;
  /** @type {import("./service.js").Target | null} */
  #target = null;
  /** @type {Sight["corners"] | null} */
  #corners = null;
  #flash = 0;

  /**
   * @param {number} position of the camera
   * @param {import("../lib/capture/streams.js").Half | null} half of its stream
   */
  constructor(position, half) {
    this.video = el("video", {
      muted: true,
      playsinline: true,
      "aria-hidden": "true",
      class: half ? `half ${half}` : "",
    });
    this.video.muted = true;
    const name = (/** @type {string} */ kind, /** @type {string} */ tag = "polygon") => make(tag, { class: kind });
    this.#parts = {
      ghost: name("ghost", "path"),
      seenOutline: name("seen-outline"),
      targetBack: name("target-back"),
      target: name("target"),
      targetCorner: make("circle", { class: "target-corner", r: 9, cx: -99, cy: -99 }),
      corners: make("g"),
    };
    this.#marks = make(
      "svg",
      { "aria-hidden": "true", preserveAspectRatio: "xMidYMid meet" },
      Object.values(this.#parts),
    );
    this.#stage = el("div", { class: "stage" }, this.video, this.#marks);
    this.#caption = el("figcaption", {});
    this.root = el("figure", { class: "picture", "data-position": position }, this.#stage, this.#caption);
  }

  /** @param {[number, number]} size of the picture, px @param {boolean} mirrored shown as a mirror */
  shape([width, height], mirrored) {
    this.#stage.style.aspectRatio = `${width} / ${height}`;
    this.#stage.classList.toggle("mirrored", mirrored);
    this.#marks.setAttribute("viewBox", `-0.5 -0.5 ${width} ${height}`);
  }

  /** @param {Sight} sight @param {import("../lib/board.js").Board} board @param {string} caption */
  render(sight, board, caption) {
    const { target, corners } = sight;
    if (target !== this.#target) drawTarget(this.#parts, board, target);
    if (corners !== this.#corners) drawBoard(this.#parts, sight);
    this.#parts.ghost.style.opacity = String(visibleShare(sight.overlap));
    [this.#target, this.#corners] = [target, corners];
    write(this.#caption, caption);
  }

  /** Shows that a view was taken. */
  flash() {
    this.root.classList.add("taken");
    clearTimeout(this.#flash);
    this.#flash = Number(setTimeout(() => this.root.classList.remove("taken"), FLASH_MS));
  }
}
