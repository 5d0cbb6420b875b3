// Requests to the service, repeated while they may still succeed.
import { isTransient, retry, retryAfter } from "./retry.js";

/** The service returned an error, or cannot be reached. */
export class LookupError extends Error {
  /** @param {string} message @param {number} status HTTP status; 0: no answer at all @param {ErrorOptions} [options] */
  constructor(message, status, options) {
    super(message, options);
    this.name = "LookupError";
    this.status = status;
  }
}

/**
 * @typedef {import("./calibration.js").CalibrationData} CalibrationData
 * @typedef {{response: Response, body: any}} JsonResponse a response and its JSON
 *
 * @typedef {object} RequestOptions
 * @property {string} token API token
 * @property {string | URL} [api] address of the API; that of the host this file came from by default
 * @property {AbortSignal} [signal]
 * @property {number} [retries] how often to ask again where another time may help; 3 by default
 * @property {typeof globalThis.fetch} [fetch]
 * @property {(milliseconds: number, signal?: AbortSignal) => Promise<void>} [pause]
 */

const FIRST_DELAY_MS = 500; // ms, then twice as long each time
const MAX_DELAY_MS = 8000; // ms; a service that asks for more gets no retry

/**
 * Address of this file. In a statement of its own, because bundlers pack the file of `new URL(…, import.meta.url)`.
 */
const HERE = import.meta.url ?? "file:///";

/** @param {string | URL} [api] @returns {URL} ending in a slash; an address without a host is this page's */
export function address(api) {
  return new URL(`${api ?? new URL("../v1", HERE)}/`.replace(/\/+$/, "/"), globalThis.location?.href);
}

/**
 * Sends a request, and retries if that may help.
 * @param {string} path below the API's address @param {RequestInit} request @param {RequestOptions} options
 * @returns {Promise<JsonResponse>} rejects with LookupError when nothing answers, or as its signal says
 */
export async function ask(path, request, { token, api, signal, retries = 3, fetch = globalThis.fetch, pause = sleep }) {
  if (!token) throw new TypeError("calibDB is asked with an API token: { token }");
  const url = new URL(path, address(api));
  if (!url.protocol.startsWith("http"))
    throw new TypeError("these modules were not loaded from calibDB, so say where it is: { api }");
  const headers = { authorization: `Bearer ${token}`, "content-type": "application/json" };
  const outcome = await retry(
    () => {
      signal?.throwIfAborted();
      return reach(fetch, url, { ...request, headers, signal });
    },
    (result, count) => {
      const response = "response" in result ? result.response : null;
      if (count >= retries || (response && !isTransient(response))) return null;
      const wait = Math.max(response ? retryAfter(response) : 0, backoff(count));
      return wait <= MAX_DELAY_MS ? wait : null;
    },
    (wait) => pause(wait, signal),
  );
  if ("response" in outcome) return outcome;
  throw new LookupError("calibDB cannot be reached", 0, { cause: outcome });
}

/**
 * @param {JsonResponse} answer
 * @returns {CalibrationData} throws a LookupError, in the service's words, for whatever is none
 */
export function calibrationIn({ response, body }) {
  if (response.ok && body.camera_matrix) return body;
  throw refusal(response, body);
}

/** @param {Response} response @param {any} body @returns {LookupError} in the service's words */
export function refusal({ ok, status, url }, body) {
  return new LookupError(
    body.detail ?? (ok ? `what answers at ${url} is not calibDB` : `calibDB answered ${status}`),
    status,
  );
}

/**
 * A response with its JSON, or the error by which `fetch` reports that there is none.
 * @param {typeof globalThis.fetch} fetch
 * @param {URL} url
 * @param {RequestInit} request
 * @returns {Promise<JsonResponse | Error>}
 */
export async function reach(fetch, url, request) {
  try {
    const response = await fetch(url, request);
    const json = /json/.test(response.headers.get("content-type") ?? "");
    return { response, body: json ? await response.json() : {} };
  } catch (error) {
    // How fetch() says that there is no network, or that it went away in mid-answer.
    if (error instanceof TypeError || error instanceof SyntaxError) return error;
    throw error;
  }
}

/**
 * Milliseconds to wait after so many retries, with jitter: many may have been refused at once.
 * @param {number} retries
 */
const backoff = (retries) => FIRST_DELAY_MS * 2 ** retries * (0.5 + 0.5 * Math.random());

/** @param {number} milliseconds @param {AbortSignal} [signal] @returns {Promise<void>} */
function sleep(milliseconds, signal) {
  return new Promise((resolve, reject) => {
    const stop = () => {
      clearTimeout(timer);
      reject(signal?.reason);
    };
    const timer = setTimeout(() => {
      signal?.removeEventListener("abort", stop);
      resolve();
    }, milliseconds);
    signal?.addEventListener("abort", stop, { once: true });
  });
}
