// All that is sent besides the corners: as a table for people, and as it is sent.
import { el } from "../lib/dom.js";
import { hasMessage, number, formatSize, t } from "../lib/i18n.js";
import { lensName } from "./status-text.js";

/** @typedef {import("../lib/session.js").SessionRequest} SessionRequest */

const MAX_DIGITS = 2; // after the point, of settings of the camera

/** @param {SessionRequest} request @returns {[name: string, value: string][]} */
export function requestFacts({ track, ...request }) {
  return Object.entries({ ...request, ...track }).map(([name, value]) => [
    hasMessage(`capture.fact_${name}`) ? t(`capture.fact_${name}`) : name,
    factText(name, value),
  ]);
}

/** @param {string} name @param {unknown} value */
function factText(name, value) {
  if (name === "distortion_model") return lensName(String(value));
  if (name === "target_error") return `${number(Number(value), MAX_DIGITS)}\u00a0px`;
  if (name === "board") return boardText(/** @type {import("../lib/board.js").Board} */ (value));
  if (Array.isArray(value)) return formatSize(value);
  if (typeof value === "number") return number(value, Number.isInteger(value) ? 0 : MAX_DIGITS);
  return typeof value === "object" ? JSON.stringify(value) : String(value);
}

/** @param {import("../lib/board.js").Board} board */
function boardText({ squares: [columns, rows], dictionary, marker_ratio }) {
  return t("capture.board_facts", { columns, rows, dictionary, ratio: number(marker_ratio, MAX_DIGITS) });
}

/** @param {SessionRequest} request @returns {HTMLTableRowElement[]} */
export const factRows = (request) =>
  requestFacts(request).map(([name, value]) =>
    el("tr", {}, el("th", { scope: "row" }, name), el("td", { class: "words" }, value)),
  );

/** The request as JSON. @param {SessionRequest | null} request */
export const requestText = (request) => (request ? JSON.stringify(request, null, 2) : "");
