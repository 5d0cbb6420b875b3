// The page's address: of the capture while there is one, of its result afterwards, so that a reload shows what is there.

import { asked, inLanguage } from "../lib/i18n.js";

/** Says that the page is opened to go on with what is kept. */
export const GO_ON = "#go-on";

/** @param {URLSearchParams} parameters */
const queryOf = (parameters) => (parameters.size > 0 ? `?${parameters}` : "");

/** What of the page's address says what it captures: in which language does not. @param {URLSearchParams | string} parameters */
export function address(parameters) {
  const own = new URLSearchParams(parameters);
  own.delete("lang");
  return queryOf(own);
}

const CAPTURE = location.pathname;

/** @param {URLSearchParams} parameters */
export function atCapture(parameters) {
  history.replaceState(null, "", CAPTURE + queryOf(parameters));
}

/** @param {URLSearchParams} parameters @param {string | null} id of the result, if it has one */
export function atResult(parameters, id) {
  if (!id) return;
  const query = new URLSearchParams({ id });
  for (const name of ["return_to", "lang"]) {
    const value = parameters.get(name);
    if (value !== null) query.set(name, value);
  }
  history.replaceState(null, "", new URL(`../result/?${query}`, new URL(CAPTURE, location.origin)));
}

/** Opens this page anew, to go on there. @param {string} other address, see above */
export function goTo(other) {
  const [there, spoken] = [new URL(CAPTURE + other + GO_ON, location.origin).href, asked()];
  location.assign(spoken === null ? there : inLanguage(there, spoken));
}
