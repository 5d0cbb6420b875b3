// Start of every page: messages in the visitor's language, and a service worker that caches its files.
import { offerLanguages, t, translate } from "./i18n.js";

/** Makes what every page has work: its language, its fields, its consent block, its cached files. */
export function openPage() {
  const select = document.getElementById("language");
  if (select instanceof HTMLSelectElement) offerLanguages(select);
  translate(document.documentElement);
  document.addEventListener("invalid", explainField, { capture: true });
  document.addEventListener("input", ({ target }) => clearExplanation(target));
  document.addEventListener(
    "click",
    ({ target }) => {
      // A script may have filled the field in since: the form is checked again.
      const form = target instanceof Element ? target.closest("button")?.form : null;
      for (const field of form?.elements ?? []) clearExplanation(field);
    },
    { capture: true },
  );
  // Pages that calibrate have a consent block.
  if (document.getElementById("consent")) void import("./consent.js").then(({ offerConsent }) => offerConsent());
  if (document.readyState === "complete") cacheFiles();
  else addEventListener("load", cacheFiles, { once: true });
}

/**
 * Registers sw.js, which fetches all files of the pages, those of the detector's worker among them: once this page is
 * there, so that it does not compete for the line. Without it everything works, but is fetched again with each visit.
 */
function cacheFiles() {
  const worker = new URL("../sw.js", import.meta.url);
  navigator.serviceWorker?.register(worker).catch((error) => console.info("pages are not cached:", error.message));
}

/** Fields whose custom validity is a text of ours. @type {WeakSet<EventTarget>} */
const explained = new WeakSet();

/**
 * Says in the page's language what a form's field lacks; the browser's own text is in its own language.
 * @param {Event} event
 */
function explainField({ target }) {
  if (!(target instanceof HTMLInputElement) || target.validity.customError) return;
  const {
    validity: { valueMissing },
    min,
    max,
  } = target;
  const isNumber = target.type === "number" && min && max;
  if (!valueMissing && !isNumber) return;
  explained.add(target);
  target.setCustomValidity(isNumber ? t("common.fill_in_number", { min, max }) : t("common.fill_in"));
}

/** @param {EventTarget | null} field */
function clearExplanation(field) {
  if (field instanceof HTMLInputElement && explained.delete(field)) field.setCustomValidity("");
}
