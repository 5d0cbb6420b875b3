// Copying texts.
import { copy } from "../lib/code-block.js";
import { el } from "../lib/dom.js";
import { t } from "../lib/i18n.js";

const SHOWN_MS = 2500; // ms for which a button says that it has copied
/** Times until which buttons say so, by id: the page may be drawn again meanwhile. @type {Map<string, number>} */
const copiedUntil = new Map();

/**
 * Button that copies a text.
 * @param {() => string} text @param {string} what name of it, for those who cannot see where the button stands
 * @param {{id: string, primary?: boolean, onCopied?: () => void}} options
 */
export function copyButton(text, what, { id, primary = false, onCopied = () => {} }) {
  const label = el("span", { "aria-hidden": "true" }, t("developers.copy"));
  /** @param {number} ms */
  const showCopied = (ms) => {
    label.textContent = t("developers.copied");
    setTimeout(() => {
      label.textContent = t("developers.copy");
    }, ms);
  };
  const left = (copiedUntil.get(id) ?? 0) - Date.now();
  if (left > 0) showCopied(left);
  const button = el(
    "button",
    { type: "button", id, class: primary ? "primary copy" : "copy", "aria-label": t("developers.copy_what", { what }) },
    label,
  );
  const said = el("span", { class: "unseen", role: "status" });
  button.addEventListener("click", async () => {
    const copied = await copy(text());
    said.textContent = t(copied ? "developers.copied_what" : "developers.not_copied_what", { what });
    if (!copied) {
      label.textContent = t("developers.not_copied");
      return;
    }
    copiedUntil.set(id, Date.now() + SHOWN_MS);
    showCopied(SHOWN_MS);
    onCopied();
  });
  return el("span", { class: "copying" }, button, said);
}
