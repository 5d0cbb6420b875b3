// Choices of the visitor: the board, the type of the lens, the size of the picture and the name of the camera's mode.
import { boardQuery } from "../lib/board.js";
import { t } from "../lib/i18n.js";
import { isLensType } from "../lib/camera.js";
import { plainNotice, viewCount } from "./state.js";

/** @import { Notice, State } from "./state.js" */

/**
 * @typedef {import("../lib/board.js").SentBoard} Board
 * @typedef {[number, number]} Size px
 */

// in addresses
const BOARD_NAMES = ["kind", "squares", "marker_ratio", "dictionary", "legacy", "inverted", "tag_spacing", "surface"];

/** Writes a board into the parameters of an address. @param {URLSearchParams} parameters @param {Board} board */
export function nameBoard(parameters, board) {
  for (const name of BOARD_NAMES) parameters.delete(name);
  for (const [name, value] of boardQuery(board)) parameters.set(name, value);
}

/**
 * Takes the suggested board for the capture from now on, turns mirrored pictures back, and says so.
 * @param {Pick<import("./request-queue.js").Page, "state" | "dispatch">} page
 * @param {URLSearchParams} parameters of its address
 * @returns {{board: Board, notice: Notice} | null} null: none is suggested any more, or a view was
 *   taken meanwhile
 */
export function takeSuggestion({ state, dispatch }, parameters) {
  const {
    detector: { suggestion },
    wanted: { flipped },
  } = state();
  if (!suggestion || viewCount(state()) > 0) return null;
  const { board, mirrored } = suggestion;
  nameBoard(parameters, board);
  const [columns, rows] = board.squares;
  if (!mirrored) return { board, notice: plainNotice("capture.board_taken", { columns, rows }) };
  dispatch({ type: "flip" });
  if (flipped) parameters.delete("flipped");
  else parameters.set("flipped", "true");
  return { board, notice: plainNotice("capture.flipped", { columns, rows }) };
}

/** Views from which a type of lens is detected: with fewer, noise may look like a lens. */
const MIN_DETECTING_VIEWS = 3;

/**
 * Lets the visitor choose, and keeps the choice in the page's address.
 * @param {HTMLSelectElement} select its values are types, "" that it is detected
 * @param {URLSearchParams} parameters of the address
 * @param {(chosen: {model: State["wanted"]["distortion_model"], automatic: boolean}) => void} onChoice
 */
export function offerLensTypes(select, parameters, onChoice) {
  const asked = parameters.get("distortion_model") ?? "";
  select.value = isLensType(asked) ? asked : "";
  select.addEventListener("change", () => {
    const { value } = select;
    if (isLensType(value)) parameters.set("distortion_model", value);
    else parameters.delete("distortion_model");
    onChoice({ model: isLensType(value) ? value : "rectilinear", automatic: !isLensType(value) });
  });
}

/** True if a type is suggested that is to be taken without a question. @param {State} state */
export function isLensDetected({ phase, capture: { session }, wanted }) {
  return (
    wanted.automatic &&
    (phase === "capturing" || phase === "done") &&
    (session?.views.length ?? 0) >= MIN_DETECTING_VIEWS &&
    (session?.suggested_model ?? wanted.distortion_model) !== wanted.distortion_model
  );
}

/** Name of a mode, without what the service refuses. @param {string} text */
export const modeName = (text) =>
  text
    .replace(/[^\p{L}\p{N} °.,:+×%/-]|\d{5,}/gu, " ")
    .replace(/ +/g, " ")
    .replace(/^[^\p{L}\p{N}]+|[^\p{L}\p{N}°%+]+$/gu, "");

/** More than any camera has: the nearest to it is the camera's own largest. */
const MAX_SIZE = /** @type {Size} */ ([15360, 8640]);
const OFFERED = /** @type {Size[]} */ ([
  [1280, 720],
  [1920, 1080],
  [640, 480],
]);

/** The size of the picture to ask the camera for. What it then gives is what is calibrated. */
export class Sizes {
  static USUAL = /** @type {Size} */ ([1280, 720]);
  #select;
  #offered;

  /** @param {HTMLSelectElement} select @param {Size} asked what the page was opened for */
  constructor(select, asked) {
    this.#select = select;
    const others = OFFERED.filter((size) => String(size) !== String(asked));
    this.#offered = [asked, ...others, MAX_SIZE];
    this.write();
  }

  /** @returns {Size} */
  get chosen() {
    return this.#offered[Math.max(0, this.#select.selectedIndex)];
  }

  /** In the visitor's language. */
  write() {
    const { selectedIndex } = this.#select;
    this.#select.replaceChildren(
      ...this.#offered.map((size) => new Option(size === MAX_SIZE ? t("capture.largest") : size.join(" × "))),
    );
    this.#select.selectedIndex = Math.max(0, selectedIndex);
  }
}
