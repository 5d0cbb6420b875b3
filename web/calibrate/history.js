// Address of the capture page: of the capture while it runs, of its result afterwards, so that a reload shows what is there.

import { asked, inLanguage } from "../lib/i18n.js";

/** Fragment of an address that resumes the saved capture. */
export const RESUME = "#go-on";

const CAPTURE_PATH = location.pathname;

/** @param {URLSearchParams} parameters */
const queryOf = (parameters) => (parameters.size > 0 ? `?${parameters}` : "");

/** The part of the address that says what is captured: the language does not. @param {URLSearchParams | string} parameters */
export function captureQuery(parameters) {
  const own = new URLSearchParams(parameters);
  own.delete("lang");
  return queryOf(own);
}

/** @param {URLSearchParams} parameters */
export function showCaptureAddress(parameters) {
  history.replaceState(null, "", CAPTURE_PATH + queryOf(parameters));
}

/** @param {URLSearchParams} parameters @param {string | null} id of the result, if it has one */
export function showResultAddress(parameters, id) {
  if (!id) return;
  const query = new URLSearchParams({ id });
  for (const name of ["return_to", "lang"]) {
    const value = parameters.get(name);
    if (value !== null) query.set(name, value);
  }
  history.replaceState(null, "", new URL(`../result/?${query}`, new URL(CAPTURE_PATH, location.origin)));
}

/** Reloads this page with another query, and resumes the capture there. @param {string} query as `captureQuery` gives it */
export function resumeAt(query) {
  const [address, language] = [new URL(CAPTURE_PATH + query + RESUME, location.origin).href, asked()];
  location.assign(language === null ? address : inLanguage(address, language));
}
