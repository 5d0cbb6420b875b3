// Start of every page: messages in the visitor's language, and a service worker that caches its files.
import { addMessages, offerLanguages, translate } from "./i18n.js";
import common from "../messages/common.js";

/** @param {Record<string, import("./i18n.js").Catalog>} catalogs messages of this page */
export function openPage(catalogs) {
  addMessages({ common, ...catalogs });
  const select = document.getElementById("language");
  if (select instanceof HTMLSelectElement) offerLanguages(select);
  translate(document.documentElement);
  // Pages that calibrate have a consent block.
  if (document.getElementById("consent")) void import("./consent.js").then(({ offerConsent }) => offerConsent());
  if (document.readyState === "complete") cacheFiles();
  else addEventListener("load", cacheFiles, { once: true });
}

/**
 * Registers sw.js, which fetches all files of the pages, those of the detector's worker among them: once this page is there,
 * so that it does not compete for the line. Without it everything works, but is fetched anew with each visit.
 */
function cacheFiles() {
  const worker = new URL("../sw.js", import.meta.url);
  navigator.serviceWorker?.register(worker).catch((error) => console.info("pages are not cached:", error.message));
}
