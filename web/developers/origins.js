// Origins that a token may name, read from what a person types; `layers/service/calibdb/schema/origins.py` decides.

/**
 * @typedef {"none" | "too_many" | "unreadable" | "wildcard" | "scheme" | "secure" | "port" | "address" | "name"} Fault
 */
/** @typedef {{text: string, fault: Fault}} Wrong */

const MAX_ORIGINS = 10;
const LOOPBACK = /^(?:(?:[a-z0-9-]+\.)*localhost|127(?:\.\d{1,3}){3}|\[::1\])$/;
const ADDRESS = /^(?:\d{1,3}(?:\.\d{1,3}){3}|\[.*\])$/;
const DOMAIN = /^(?:[a-z0-9](?:[a-z0-9-]{0,61}[a-z0-9])?\.)+[a-z](?:[a-z0-9-]{0,61}[a-z0-9])?$/;
const PRIVATE = /\.(?:local|internal|home\.arpa|onion|arpa|localhost)$/;

/**
 * The origins in a text, as browsers write them: an address of a page stands for its origin.
 * @param {string} text separated by white space or commas
 * @returns {{origins: string[], wrong: Wrong | null}} wrong: the first that no token can name
 */
export function originsIn(text) {
  const words = text.split(/[\s,;]+/).filter(Boolean);
  if (words.length === 0) return { origins: [], wrong: { text: "", fault: "none" } };
  /** @type {Set<string>} */
  const origins = new Set();
  for (const word of words) {
    const read = originOf(word);
    if ("fault" in read) return { origins: [...origins], wrong: { text: word, fault: read.fault } };
    origins.add(read.origin);
  }
  const wrong =
    origins.size > MAX_ORIGINS ? /** @type {const} */ ({ text: String(MAX_ORIGINS), fault: "too_many" }) : null;
  return { origins: [...origins], wrong };
}

/** True if an origin is on the visitor's own machine. @param {string} origin */
export const isLoopback = (origin) => URL.canParse(origin) && LOOPBACK.test(new URL(origin).hostname);

/** @param {string} word @returns {{origin: string} | {fault: Fault}} */
function originOf(word) {
  if (word.includes("*")) return { fault: "wildcard" };
  const own = /^(?:localhost|127\.|\[::1\]|[^/:]*\.localhost)/i.test(word);
  const address = /^[a-z][a-z0-9+.-]*:\/\//i.test(word) ? word : `${own ? "http" : "https"}://${word}`;
  if (!URL.canParse(address)) return { fault: "unreadable" };
  const { protocol, hostname, port, origin } = new URL(address);
  if (!/^https?:$/.test(protocol)) return { fault: "scheme" };
  if (LOOPBACK.test(hostname)) return { origin };
  if (ADDRESS.test(hostname)) return { fault: "address" };
  if (!DOMAIN.test(hostname) || PRIVATE.test(`.${hostname}`)) return { fault: "name" };
  if (protocol !== "https:") return { fault: "secure" };
  return port ? { fault: "port" } : { origin };
}
