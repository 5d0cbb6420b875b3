// Controls of a result's card: copying, sharing, and explanations of a word.
import { copy } from "../code-block.js";
import { button, el } from "../dom.js";
import { t } from "../i18n.js";

/**
 * A button that copies a text, and says so.
 * @param {string} label @param {() => string} text @param {Record<string, string>} [attributes]
 */
export function copyButton(label, text, attributes = {}) {
  const button = el("button", { type: "button", ...attributes }, label);
  const said = el("span", { class: "unseen", role: "status" });
  const hidden = el("span", { class: "copies-it" }, button, said);
  button.addEventListener("click", async () => {
    const done = await copied(text(), hidden);
    // The button keeps its width while its label changes, so that nothing next to it moves under a finger.
    button.style.minWidth = `${Math.ceil(button.getBoundingClientRect().width)}px`;
    button.textContent = t(done ? "result.copied" : "result.copy_failed");
    said.textContent = button.textContent;
    button.addEventListener(
      "blur",
      () => {
        button.textContent = label;
        said.textContent = "";
      },
      { once: true },
    );
  });
  return hidden;
}

/**
 * @param {string} text @param {HTMLElement} parent of a field that exists for a moment
 * @returns {Promise<boolean>}
 */
async function copied(text, parent) {
  if (await copy(text)) return true;
  // The clipboard API needs HTTPS and permission. Without them, the old command copies.
  const field = el("textarea", { class: "unseen", "aria-hidden": "true" });
  field.value = text;
  parent.append(field);
  field.select();
  const done = document.execCommand("copy");
  field.remove();
  return done;
}

/**
 * A button that hands an address on: by the system's own sheet on a phone, by the clipboard elsewhere.
 * @param {string} title @param {string} address @param {Record<string, string>} attributes
 */
export function shareButton(title, address, attributes) {
  if (!navigator.share || !matchMedia("(pointer: coarse)").matches)
    return copyButton(t("result.copy_link"), () => address, attributes);
  const share = () =>
    navigator.share({ title, url: address }).catch((error) => {
      if (!(error instanceof DOMException)) throw error; // closed without sharing
    });
  return button(t("result.share"), share, attributes);
}

/** Actions that are seldom wanted, behind three dots. @param {Node[]} actions */
export function moreMenu(actions) {
  const menu = el(
    "details",
    { class: "menu more" },
    el("summary", { "aria-label": t("result.more"), title: t("result.more") }, "⋯"),
    el("ul", {}, ...actions.map((action) => el("li", {}, action))),
  );
  menu.addEventListener("focusout", ({ relatedTarget }) => {
    if (relatedTarget instanceof Node && !menu.contains(relatedTarget)) menu.open = false;
  });
  return menu;
}

/** A word's explanation, behind a question mark. @param {string} word @param {string} text */
export function hint(word, text) {
  const details = el(
    "details",
    { class: "hint" },
    el("summary", { "aria-label": t("result.what_is", { word }) }, "?"),
    el("p", {}, text),
  );
  details.addEventListener("keydown", (event) => {
    if (event.key === "Escape") details.open = false;
  });
  details.addEventListener("focusout", (event) => {
    if (!details.contains(/** @type {Node | null} */ (event.relatedTarget))) details.open = false;
  });
  return details;
}
