// Pages of the documentation: search, the site's address and the visitor's token in examples.
import { openPage } from "../lib/page.js";
import { offerSearch } from "./search.js";
import { NO_TOKEN, chooseToken, chosenToken, keptTokens } from "./tokens.js";

openPage();
fillIn();
offerTokens();
offerScrolling();
offerSearch();
unfoldContents();

/** Opens the list of headings if it has a column of its own. */
function unfoldContents() {
  const contents = document.querySelector("details.contents");
  if (contents && matchMedia("(min-width: 84rem)").matches) contents.setAttribute("open", "");
}

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
  select.addEventListener("change", () => {
    chooseToken(select.value);
    fillIn();
    dispatchEvent(new Event("calibdb-token"));
  });
}

/** Tables that scroll sideways are reached by the keyboard. */
function offerScrolling() {
  for (const wide of document.querySelectorAll(".wide")) {
    if (wide.scrollWidth > wide.clientWidth) wide.setAttribute("tabindex", "0");
  }
}
