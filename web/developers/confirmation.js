// Question before something that cannot be undone.
import { el } from "../lib/dom.js";
import { t } from "../lib/i18n.js";

/**
 * @param {{heading: string, text: string, yes: string, no?: string}} question in words
 * @returns {Promise<boolean>} false, too, where the question is closed
 */
export function askConfirmation({ heading, text, yes, no = t("developers.keep_it") }) {
  const [agree, decline] = [
    el("button", { type: "submit", value: "yes", class: "danger" }, yes),
    el("button", { type: "submit", value: "no", autofocus: true }, no),
  ];
  const dialog = el(
    "dialog",
    { class: "question", "aria-labelledby": "question-heading", "aria-describedby": "question-text" },
    el(
      "form",
      { method: "dialog" },
      el("h2", { id: "question-heading" }, heading),
      el("p", { id: "question-text" }, text),
      el("div", { class: "actions" }, decline, agree),
    ),
  );
  // A closed dialog is removed by its event, which may come later than the next question.
  for (const closed of document.querySelectorAll("dialog.question")) closed.remove();
  const before = document.activeElement;
  document.body.append(dialog);
  dialog.showModal();
  return new Promise((resolve) => {
    dialog.addEventListener("close", () => {
      dialog.remove();
      if (before instanceof HTMLElement && before.isConnected) before.focus();
      resolve(dialog.returnValue === "yes");
    });
  });
}
