// View of a result on pages that show one only at their end: its modules are loaded when there is something to show,
// and a stored result has its own address while it is shown, instead of the form. A reload shows it again, Back leads
// to the form.
import { pageUrl, t } from "../i18n.js";

/**
 * @import { Result } from "./numbers.js"
 * @import { ResultView } from "./view.js"
 */

/** Shows results in an element, as ResultView does. */
export class LaterResultView {
  #root;
  /** @type {Promise<ResultView> | null} */
  #view = null;
  /** Number of the latest result: one that was cleared before the modules were there is not shown. */
  #turn = 0;
  /** The stored result that is shown, or was before Back. @type {string | null} */
  #id = null;
  #title = "";
  #form = { address: "", title: "" };

  /** @param {HTMLElement} root */
  constructor(root) {
    this.#root = root;
    addEventListener("popstate", ({ state }) => {
      if (state?.result && state.result !== this.#id)
        location.reload(); // one before the last
      else this.#look(Boolean(state?.result));
    });
  }

  /** Loads the modules, ahead of the result. @returns {Promise<ResultView>} */
  prepare() {
    this.#view ??= import("./view.js")
      .then(({ ResultView }) => new ResultView(this.#root))
      .catch((error) => {
        this.#view = null; // the next attempt loads them again
        throw error;
      });
    return this.#view;
  }

  /** @param {Result} result */
  async show(result) {
    const turn = ++this.#turn;
    const [view, { pageTitle }] = await Promise.all([this.prepare(), import("./card.js")]);
    if (turn !== this.#turn) return;
    view.show(result);
    const {
      calibration: { id },
      returnTo,
    } = result;
    if (!id) return;
    this.#id = id;
    this.#title = pageTitle(result.calibration, result.report);
    if (!this.#isShown) this.#form.address = location.href;
    const query = new URLSearchParams({ id, ...(returnTo ? { return_to: returnTo } : {}) });
    history.pushState({ result: id }, "", pageUrl(`result/?${query}`));
    this.#look(true);
    scrollTo(0, 0);
  }

  get #isShown() {
    return this.#root.parentElement?.classList.contains("showing-result") === true;
  }

  /** Shows the result or the form. @param {boolean} isResult */
  #look(isResult) {
    this.#root.parentElement?.classList.toggle("showing-result", isResult);
    this.#root.hidden = !isResult;
    const title = document.querySelector("title");
    if (!title) return;
    this.#form.title ||= title.dataset.t ?? "";
    // A change of language leaves the title of a result alone.
    if (isResult) delete title.dataset.t;
    else title.dataset.t = this.#form.title;
    title.textContent = isResult ? this.#title : t(this.#form.title);
  }

  /** Empties the element, and shows the form. */
  clear() {
    this.#turn += 1;
    if (this.#isShown) {
      history.pushState(null, "", this.#form.address);
      this.#look(false);
    }
    this.#id = null;
    void this.#view?.then(
      (view) => view.clear(),
      () => {},
    );
  }
}
