// Form in which a board is described: presets, and, folded away, every parameter of its kind.
import { CIRCLES, DEFAULT_BOARD, DEFAULT_TAG_SPACING, DICTIONARIES, boardFrom, isSameBoard, kindOf } from "./board.js";
import { boardWords, reason } from "./board-text.js";
import { part } from "./dom.js";
import { onLanguage, t } from "./i18n.js";

/** @import { Problem, SentBoard } from "./board.js" */

/**
 * @typedef {object} Use the form within a page
 * @property {(board: SentBoard) => void} onChoice called when the visitor has chosen another board
 * @property {(reason: string) => string} problemText words for a board that cannot be
 * @property {"input" | "change"} [event] when a field counts: with every key, or when it is left
 * @property {boolean} [circles] whether grids of circles are offered, which no page detects
 * @property {() => void} [onArrange] called when the board, or the language, is another one
 */

/**
 * Boards that people own or are sold, by the names under which they know them.
 * @type {{id: string, name: string, board: SentBoard}[]} name: a proper name, the same in every language
 */
export const PRESETS = [
  { id: "calibdb", name: "calibDB", board: DEFAULT_BOARD },
  {
    id: "photonvision",
    name: "PhotonVision 8 × 8",
    board: { squares: [8, 8], marker_ratio: 0.75, dictionary: "DICT_4X4_1000", legacy: false },
  },
  {
    id: "calibio",
    name: "calib.io 14 × 9",
    board: { squares: [14, 9], marker_ratio: 0.75, dictionary: "DICT_5X5_100", legacy: false },
  },
  {
    id: "opencv_charuco",
    name: "OpenCV ChArUco 5 × 7",
    board: { squares: [5, 7], marker_ratio: 0.5, dictionary: "DICT_6X6_250", legacy: false },
  },
  {
    id: "opencv_chessboard",
    name: "OpenCV 10 × 7",
    board: { kind: "chessboard", squares: [10, 7], marker_ratio: 0.65, dictionary: "DICT_4X4_50", legacy: false },
  },
  {
    id: "kalibr",
    name: "Kalibr AprilGrid 6 × 6",
    board: {
      kind: "aprilgrid",
      squares: [6, 6],
      marker_ratio: 0.65,
      dictionary: "DICT_APRILTAG_36h11",
      legacy: false,
      tag_spacing: DEFAULT_TAG_SPACING,
    },
  },
];

const OTHER = "other";

export class BoardForm {
  #fields = {
    preset: part("preset", HTMLSelectElement),
    kind: part("board-kind", HTMLSelectElement),
    columns: part("columns", HTMLInputElement),
    rows: part("rows", HTMLInputElement),
    dictionary: part("dictionary", HTMLSelectElement),
    ratio: part("ratio", HTMLInputElement),
    spacing: part("spacing", HTMLInputElement),
    legacy: part("legacy", HTMLInputElement),
    inverted: part("inverted", HTMLInputElement),
  };
  #edit = part("board-edit", HTMLDetailsElement);
  #problem = part("board-problem", HTMLElement);
  #board;
  #use;
  /** @type {Problem | null} */
  #wrong = null;

  /** @param {SentBoard} board @param {Use} use */
  constructor(board, use) {
    this.#board = board;
    this.#use = use;
    const { onChoice, event = "change" } = use;
    const { preset, dictionary } = this.#fields;
    preset.append(...PRESETS.map(({ id, name }) => new Option(name, id)), new Option("", OTHER));
    if (use.circles) this.#fields.kind.append(...CIRCLES.map((kind) => new Option("", kind)));
    dictionary.append(...DICTIONARIES.map((name) => new Option(name, name)));
    preset.addEventListener("change", () => {
      const chosen = PRESETS.find(({ id }) => id === preset.value);
      if (!chosen) {
        this.#edit.open = true;
        return this.#fields.kind.focus();
      }
      this.show(chosen.board);
      onChoice(chosen.board);
    });
    part("board-form", HTMLFormElement).addEventListener(event, ({ target }) => {
      if (target === preset) return;
      const read = this.#readFields();
      this.#say(read.problem);
      if (read.problem) return;
      this.#board = read.board;
      this.#arrange();
      onChoice(read.board);
    });
    part("board-form", HTMLFormElement).addEventListener("submit", (event) => {
      event.preventDefault();
      if (!this.#wrong) onChoice(this.#board);
    });
    onLanguage(() => this.#arrange());
    this.show(board);
  }

  /** @param {SentBoard} board */
  show(board) {
    this.#board = board;
    const { kind, columns, rows, dictionary, ratio, spacing, legacy, inverted } = this.#fields;
    kind.value = kindOf(board);
    [columns.value, rows.value] = board.squares.map(String);
    dictionary.value = board.dictionary;
    ratio.value = String(board.marker_ratio);
    spacing.value = String(board.tag_spacing ?? DEFAULT_TAG_SPACING);
    legacy.checked = board.legacy ?? false;
    inverted.checked = board.inverted ?? false;
    this.#say(null);
    this.#arrange();
  }

  focus() {
    this.#fields.preset.focus();
  }

  /** Board of the fields. */
  #readFields() {
    const { kind, columns, rows, dictionary, ratio, spacing, legacy, inverted } = this.#fields;
    const isGrid = kind.value === "aprilgrid";
    const family = isGrid && !dictionary.value.startsWith("DICT_APRILTAG_") ? "DICT_APRILTAG_36h11" : dictionary.value;
    dictionary.value = family;
    return boardFrom(
      new URLSearchParams({
        kind: kind.value,
        squares: `${columns.value}x${rows.value}`,
        inverted: String(inverted.checked),
        ...(["charuco", "aprilgrid"].includes(kind.value) && { dictionary: family }),
        ...(kind.value === "charuco" && { legacy: String(legacy.checked) }),
        ...(["charuco", ...CIRCLES].includes(kind.value) && { marker_ratio: ratio.value }),
        ...(isGrid && { tag_spacing: spacing.value }),
      }),
      { circles: this.#use.circles },
    );
  }

  /** Shows the fields of this kind of board, and in which words it is known. */
  #arrange() {
    const kind = kindOf(this.#board);
    for (const field of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("[data-kinds]"))) {
      field.hidden = !(field.dataset.kinds ?? "").split(" ").includes(kind);
    }
    const { preset, kind: kinds } = this.#fields;
    for (const option of kinds.options)
      if (CIRCLES.includes(option.value)) option.text = t(`boards.kind_${option.value}`);
    preset.options[preset.options.length - 1].textContent = t("boards.preset_other");
    preset.value = PRESETS.find(({ board }) => isSameBoard(board, this.#board))?.id ?? OTHER;
    this.#edit.open ||= preset.value === OTHER;
    this.#use.onArrange?.();
    this.#say(this.#wrong);
  }

  /** @param {import("../lib/board.js").Problem | null} problem */
  #say(problem) {
    this.#wrong = problem;
    this.#problem.textContent = problem ? this.#use.problemText(reason(problem)) : "";
  }
}

/** The form of the board within a page: the files stay while the board changes. */
export class WhichBoard {
  #details = part("which-board", HTMLDetailsElement);
  /** @type {SentBoard} */
  #board;
  /** @type {boolean} */
  #isChosen;
  #form;

  /**
   * @param {SentBoard} board @param {(board: SentBoard) => void} onChoice called when the visitor has chosen another
   * @param {boolean} isChosen true if the visitor has chosen this board; else the board is recognised
   */
  constructor(board, onChoice, isChosen) {
    [this.#board, this.#isChosen] = [board, isChosen];
    this.#form = new BoardForm(board, {
      onChoice: (chosen) => {
        this.#take(chosen, true);
        onChoice(chosen);
      },
      onArrange: () => this.#say(),
      problemText: (reason) => t("boards.impossible", { reason }),
    });
  }

  /** @param {SentBoard} board @param {boolean} [isChosen] */
  show(board, isChosen = true) {
    this.#take(board, isChosen);
    this.#form.show(board);
  }

  open() {
    this.#details.open = true;
    this.#form.focus();
  }

  /** @param {SentBoard} board @param {boolean} isChosen */
  #take(board, isChosen) {
    [this.#board, this.#isChosen] = [board, isChosen];
    this.#say();
  }

  #say() {
    part("board", HTMLElement).textContent = this.#isChosen ? boardWords(this.#board) : t("boards.automatic");
  }
}
