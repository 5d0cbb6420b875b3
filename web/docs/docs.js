// Pages of the documentation: search, code that can be copied, the site's address and the visitor's token in examples.
import { el } from "../lib/dom.js";
import { onLanguage, t } from "../lib/i18n.js";
import { openPage } from "../lib/page.js";
import words from "../messages/docs.js";
import { offerSearch } from "./search.js";
import { NO_TOKEN, chooseToken, chosenToken, keptTokens } from "./tokens.js";

const COPIED_MS = 2000;

openPage({ docs: words });
fillIn();
offerTokens();
offerCopies();
offerSearch();

/** Puts address and token into examples. */
function fillIn() {
  const values = { origin: location.origin, token: chosenToken()?.token ?? NO_TOKEN };
  for (const place of document.querySelectorAll("[data-fill]")) {
    const value = values[/** @type {"origin" | "token"} */ (/** @type {HTMLElement} */ (place).dataset.fill)];
    if (place.textContent !== value) place.textContent = value;
  }
}

/** Lets the visitor choose among tokens, where there are any. */
function offerTokens() {
  const select = document.getElementById("token");
  const tokens = keptTokens();
  if (!(select instanceof HTMLSelectElement) || tokens.length === 0) return;
  select.replaceChildren(...tokens.map(({ id, name }) => new Option(name || id, id)));
  select.value = chosenToken()?.id ?? "";
  select.hidden = false;
  select.addEventListener("change", () => {
    chooseToken(select.value);
    fillIn();
    dispatchEvent(new Event("calibdb-token"));
  });
}

/** A button at each block of code. */
function offerCopies() {
  for (const block of document.querySelectorAll(".code")) {
    const button = el("button", { type: "button", class: "copy" });
    const name = () => (button.textContent = t("docs.copy"));
    name();
    onLanguage(name);
    button.addEventListener("click", () => {
      const code = block.querySelector("code")?.textContent ?? "";
      const done = () => {
        button.textContent = t("docs.copied");
        setTimeout(name, COPIED_MS);
      };
      // Without permission the text is selected, for the keyboard to copy.
      navigator.clipboard.writeText(code).then(done, () => getSelection()?.selectAllChildren(/** @type {Node} */ (block.querySelector("code"))));
    });
    block.append(button);
  }
  // What scrolls sideways is reached by the keyboard.
  for (const wide of document.querySelectorAll(".wide")) {
    if (wide.scrollWidth > wide.clientWidth) wide.setAttribute("tabindex", "0");
  }
}
