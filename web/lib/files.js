// Files: chosen, or dropped in a place of the page; and files that are handed to the browser, which saves them.
import { el } from "./dom.js";
import { onLanguage, t } from "./i18n.js";

const KEPT_MS = 60_000; // by then the browser has read the file

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

/**
 * Input for a photo of one camera. It is read here and stays here.
 * @param {Record<string, string>} attributes of the input
 * @param {readonly [number, number]} size whose shape the image must have, px
 * @param {{onStart?: () => void, onImage: (image: ImageBitmap) => void, onProblem: (problem: "shape" | "unreadable") =>
 *   void}} actions onStart: called when a file is chosen; onImage: takes the image over
 * @returns {HTMLInputElement}
 */
export function imageInput(attributes, [width, height], { onStart = () => {}, onImage, onProblem }) {
  const input = el("input", { type: "file", accept: "image/*", class: "unseen", ...attributes });
  input.addEventListener("change", async () => {
    const [file] = input.files ?? [];
    if (!file) return;
    onStart();
    try {
      const image = await createImageBitmap(file);
      if (image.width * height === image.height * width) return onImage(image);
      image.close();
      onProblem("shape");
    } catch (error) {
      if (!(error instanceof DOMException)) throw error;
      onProblem("unreadable");
    }
  });
  return input;
}

/** @param {Blob} content @param {string} name */
export function offerFile(content, name) {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(content), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), KEPT_MS);
}

/**
 * Hands the file of a response to the browser. It is read completely before it is offered, so that a broken transfer is
 * an error, not half a file.
 * @param {Response} response @param {string} otherwise name of a file that the service has not named
 * @returns {Promise<string>} its name
 */
export async function offerResponse(response, otherwise) {
  const [, named] = /filename="?([^";]+)"?/.exec(response.headers.get("content-disposition") ?? "") ?? [];
  const name = named ?? otherwise;
  offerFile(await response.blob(), name);
  return name;
}
