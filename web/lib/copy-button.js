// A button that copies a block of code. Blocks of a page's source have one from the start (header.js); a block that is
// made
// later gets its own by `addCopyButton(pre)`, before or after it is put into the page.
import { highlightCode } from "./highlight.js";
import { onLanguage, t } from "./i18n.js";

const SHOWN_MS = 2000;

/**
 * @param {HTMLElement} pre with the code; gets a wrapper with the button, unless it has one
 * @returns {HTMLElement} the wrapper
 */
export function addCopyButton(pre) {
  if (pre.parentElement?.classList.contains("code")) return pre.parentElement;
  const wrapper = document.createElement("div");
  wrapper.className = "code";
  const button = document.createElement("button");
  button.type = "button";
  button.className = "copy";
  const said = document.createElement("span");
  said.className = "unseen";
  said.setAttribute("role", "status");
  let outcome = "";
  const show = () => {
    button.textContent = t(outcome || "common.copy");
    said.textContent = outcome && t(outcome);
  };
  let timer = 0;
  button.addEventListener("click", async () => {
    outcome = (await copy(pre)) ? "common.copied" : "common.selected";
    show();
    clearTimeout(timer);
    timer = setTimeout(() => {
      outcome = "";
      show();
    }, SHOWN_MS);
  });
  onLanguage(show);
  show();
  pre.replaceWith(wrapper);
  wrapper.append(pre, button, said);
  if (!wrapper.closest(".block")) highlightCode(pre);
  return wrapper;
}

/**
 * Copies the text; where the browser does not allow that, selects it.
 * @param {HTMLElement} pre
 * @returns {Promise<boolean>} copied?
 */
async function copy(pre) {
  try {
    await navigator.clipboard.writeText((pre.textContent ?? "").trimEnd());
    return true;
  } catch (error) {
    // Not a secure context (TypeError: there is no clipboard), or not permitted.
    if (!(error instanceof DOMException) && !(error instanceof TypeError)) throw error;
    getSelection()?.selectAllChildren(pre);
    return false;
  }
}
