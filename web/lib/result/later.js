// View of a result on pages that show one only at their end: its modules are loaded when there is something to show.

/** @typedef {import("./view.js").ResultView} ResultView */
/** @typedef {import("./result.js").Result} Result */

/** Shows results in an element, as ResultView does. */
export class LaterResultView {
  #root;
  /** @type {Promise<ResultView> | null} */
  #view = null;
  /** Number of the latest result: one that was cleared before the modules were there is not shown. */
  #turn = 0;

  /** @param {HTMLElement} root */
  constructor(root) {
    this.#root = root;
  }

  /** Loads the modules, ahead of the result. @returns {Promise<ResultView>} */
  prepare() {
    this.#view ??= import("./view.js").then(({ ResultView }) => new ResultView(this.#root)).catch((error) => {
      this.#view = null; // the next attempt loads them again
      throw error;
    });
    return this.#view;
  }

  /** @param {Result} result */
  async show(result) {
    const turn = ++this.#turn;
    const view = await this.prepare();
    if (turn === this.#turn) view.show(result);
  }

  /** Empties the element. */
  clear() {
    this.#turn += 1;
    void this.#view?.then((view) => view.clear(), () => {});
  }
}
