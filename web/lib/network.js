// Network requests with a timeout, and one error for a network that is away.

/** ms: longer than the service may take to compute, so what has not answered by then will not. */
const TIMEOUT_MS = 30_000;

/** The service could not be reached. */
export class OfflineError extends Error {
  /** @param {boolean} [silent] it was there and said nothing: another attempt would take as long again */
  constructor(silent = false) {
    super("calibDB cannot be reached. Check the connection and try again.");
    this.name = "OfflineError";
    this.silent = silent;
  }
}

/** Message of a module that did not arrive, in Chromium, Firefox and WebKit. */
const MODULE_MISSING = /dynamically imported module|Importing a module script failed/;

/** True if a request, or a module that a page loads when it needs it, did not arrive. @param {unknown} error */
export const isOffline = (error) =>
  error instanceof OfflineError || (error instanceof TypeError && MODULE_MISSING.test(error.message));

/**
 * `fetch`, whose rejections a person can read, and which does not wait for ever.
 * @param {RequestInfo | URL} address
 * @param {RequestInit & {timeout?: number}} [request] timeout: ms for the whole answer
 * @returns {Promise<Response>} rejects with OfflineError; reading the body rejects as `readable` understands
 */
export async function reach(address, { timeout = TIMEOUT_MS, signal, ...request } = {}) {
  const limit = AbortSignal.timeout(timeout);
  return readable(globalThis.fetch(address, { ...request, signal: signal ? AbortSignal.any([signal, limit]) : limit }));
}

/**
 * Report broken and missing answers as such: `fetch` and its bodies reject with a TypeError when the network fails.
 * @template T @param {Promise<T>} arriving @returns {Promise<T>}
 */
export async function readable(arriving) {
  try {
    return await arriving;
  } catch (error) {
    if (error instanceof TypeError) throw new OfflineError();
    if (error instanceof DOMException && error.name === "TimeoutError") throw new OfflineError(true);
    throw error;
  }
}
