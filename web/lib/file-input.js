// File inputs whose button and state speak the language of the page: browsers speak their own.
import { onLanguage, t } from "./i18n.js";

/**
 * Says beside an input how many files are chosen.
 * @param {HTMLInputElement} input within a label that looks like a button; the element described by its
 *   aria-describedby
 *   says the state
 */
export function sayChosen(input) {
  const state = document.getElementById(input.getAttribute("aria-describedby") ?? "");
  let count = 0;
  const say = () => {
    if (state) state.textContent = count ? t("common.files_chosen", { count }) : t("common.no_file");
  };
  input.addEventListener("change", () => {
    if (input.files?.length) count = input.files.length; // the page may empty it again, to be given the same file twice
    say();
  });
  onLanguage(say);
  say();
}
