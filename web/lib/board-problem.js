// Reasons why a board cannot be, in the language of the page.
import { onLanguage, t } from "./i18n.js";

/** @typedef {import("./board.js").Problem} Problem */

/** @param {Problem} problem */
export const reason = ({ code, values }) => t(`impossible.because_${code}`, values);

/**
 * Says on a page that the board its address asks for cannot be.
 * @param {HTMLElement} place
 * @param {Problem | null} problem
 */
export function showProblem(place, problem) {
  const say = () => {
    place.textContent = problem ? t("impossible.default_instead", { reason: reason(problem) }) : "";
  };
  place.hidden = problem === null;
  say();
  onLanguage(say);
}
