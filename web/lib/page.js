// What every page does: speaks the visitor's language, and keeps its files for the next visit.
import { learn, offerLanguages, translate } from "./i18n.js";
import common from "../messages/common.js";

/** @param {Record<string, import("./i18n.js").Room>} rooms the words of this page */
export function openPage(rooms) {
  learn({ common, ...rooms });
  const select = document.getElementById("language");
  if (select instanceof HTMLSelectElement) offerLanguages(select);
  translate(document.documentElement);
  keepFiles();
}

/** See sw.js. Without it everything works, but arrives anew with each visit. */
export function keepFiles() {
  const worker = new URL("../sw.js", import.meta.url);
  navigator.serviceWorker?.register(worker).catch((error) => console.info("pages are not kept:", error.message));
}
