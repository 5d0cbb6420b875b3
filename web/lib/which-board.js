// The form of the board within the page: the files stay while the board changes.
import { BoardForm } from "./board-form.js";
import { boardWords } from "./board-text.js";
import { part } from "./dom.js";
import { t } from "./i18n.js";

/** @typedef {import("./board.js").SentBoard} SentBoard */

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
