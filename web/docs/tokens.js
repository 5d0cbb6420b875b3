// Tokens that the visitor made on /developers/ and this browser keeps, and the one that examples use.
import { readJson } from "../lib/storage.js";

/**
 * @typedef {{id: string, token: string, management_token?: string, name?: string | null, origins?: unknown[], api?:
 *   string}} KeptToken
 */

const TOKENS_KEY = "calibdb.tokens";
const CHOSEN = "calibdb.docs.token";
/** Accepted by a service on the visitor's own machine, and there alone. */
export const DEVELOPMENT_TOKEN = "cdb_dev_local";
/** Stands in examples for the token of a visitor who has none yet. */
export const NO_TOKEN = "cdb_…";

/**
 * The tokens, newest first as /developers/ keeps them; on the visitor's own machine also that of development.
 * @returns {KeptToken[]}
 */
export function keptTokens() {
  const local = ["127.0.0.1", "localhost", "[::1]"].includes(location.hostname);
  return [...read(), ...(local ? [{ id: "development", token: DEVELOPMENT_TOKEN, name: "development token" }] : [])];
}

/** The token that examples use. @returns {KeptToken | null} */
export function chosenToken() {
  const tokens = keptTokens();
  const id = stored(() => sessionStorage.getItem(CHOSEN));
  return tokens.find((token) => token.id === id) ?? tokens[0] ?? null;
}

/** @param {string} id */
export function chooseToken(id) {
  stored(() => sessionStorage.setItem(CHOSEN, id));
}

/** @returns {KeptToken[]} */
function read() {
  const tokens = readJson(TOKENS_KEY);
  return Array.isArray(tokens)
    ? tokens.filter((each) => typeof each?.id === "string" && typeof each?.token === "string" && isHere(each.api))
    : [];
}

/** True if a token is of this service. @param {unknown} api its address, if known */
function isHere(api) {
  return (
    typeof api !== "string" ||
    (URL.canParse(api, location.href) && new URL(api, location.href).origin === location.origin)
  );
}

/**
 * Value that the browser keeps; null where it keeps nothing for pages.
 * @template T
 * @param {() => T} use
 * @returns {T | null}
 */
function stored(use) {
  try {
    return use();
  } catch (error) {
    if (!(error instanceof DOMException)) throw error;
    return null;
  }
}
