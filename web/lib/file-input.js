// File inputs: files that are chosen, or dropped in a place of the page.
import { onLanguage, t } from "./i18n.js";

/**
 * Takes files that are chosen, or dropped.
 * @param {HTMLInputElement} input @param {HTMLElement} place for files that are dropped
 * @param {(files: File[]) => void} onFiles
 */
export function takeFiles(input, place, onFiles) {
  sayChosen(input);
  input.addEventListener("change", () => {
    onFiles([...(input.files ?? [])]);
    input.value = "";
  });
  for (const name of ["dragenter", "dragover", "dragleave", "drop"]) {
    place.addEventListener(name, (event) => {
      event.preventDefault();
      place.classList.toggle("over", name === "dragenter" || name === "dragover");
      const { dataTransfer } = /** @type {DragEvent} */ (event);
      if (name === "drop") onFiles([...(dataTransfer?.files ?? [])]);
    });
  }
}

/**
 * Says next to a file input how many files are chosen, in the language of the page: browsers speak their own.
 * @param {HTMLInputElement} input within a label that looks like a button; the element described by its
 *   aria-describedby says the state
 */
function sayChosen(input) {
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
