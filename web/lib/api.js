// HTTP client of the service: bearer credentials, problems as errors, retries.

import { isTransient, retry, retryAfter } from "../sdk/retry.js";
import { OfflineError, reach, readable } from "./network.js";
import { loadSettings } from "./settings.js";

export { OfflineError };

/**
 * @typedef {object} Transport what the outside world gives; replaced in tests
 * @property {typeof reach} fetch rejects with OfflineError when there is no network, and only then we may try again
 * @property {(ms: number) => Promise<void>} wait
 * @property {AbortSignal} [signal] after which nothing more is asked
 * @property {number} [timeout] ms for one answer; unset: as long as the service may compute
 * @property {(retry: {attempt: number} | null) => void} onRetry called before each retry, and when one succeeds
 */

/** Seconds between attempts: a minute in all, about as long as a person would wait. */
export const RETRY_DELAYS_S = [0.5, 1, 2, 4, 8, 15, 30];
/** Retries for a caller that can continue without an answer: two seconds. */
const BRIEF_RETRIES = 2;
const MAX_RETRY_AFTER_MS = 60_000; // ms; a server that asks for more gets no retry

/** The service refused a request. */
export class ApiError extends Error {
  /**
   * @param {number} status
   * @param {{type?: string, title?: string, detail?: string, errors?: {field: string, detail: string}[]}} problem
   */
  constructor(status, problem) {
    const fields = (problem.errors ?? []).map(({ field, detail }) => `${field}: ${detail}`).join("; ");
    super([problem.detail ?? problem.title ?? `The service answered ${status}.`, fields].filter(Boolean).join(" "));
    this.name = "ApiError";
    this.status = status;
    /** Kind of the problem, as "session-expired". */
    this.kind = (problem.type ?? "").split(/[/:#]/).at(-1) ?? "";
  }

  /** True if a later attempt may succeed. */
  get passing() {
    return isTransient(this);
  }
}

export class Api {
  #base;
  #transport;
  /** True if the last attempt of any call failed: one that succeeds ends the waiting of all. */
  #vain = false;

  /** @param {string} base address of the API, "/v1" @param {Partial<Transport>} [transport] */
  constructor(base, transport = {}) {
    this.#base = base.replace(/\/$/, "");
    this.#transport = {
      fetch: reach,
      wait: (/** @type {number} */ ms) =>
        new Promise((/** @type {(value: void) => void} */ done) => setTimeout(done, ms)),
      onRetry: () => {},
      ...transport,
    };
  }

  /**
   * @param {string} method @param {string} path "/session" @param {string} credential
   * @param {{body?: object, accept?: string, brief?: boolean, etag?: string}} [options] brief: a timeout of two
   *   seconds, not a minute; etag: of the answer that is there already
   * @returns {Promise<Response>} one that is ok, or 304 for an answer that is there already; rejects with ApiError or
   *   OfflineError
   *
   * All calls are idempotent: the service answers a repeated view in the same way.
   */
  async send(method, path, credential, { body, accept = "application/json", brief = false, etag = "" } = {}) {
    /** @type {HeadersInit} */
    const headers = { authorization: `Bearer ${credential}`, accept };
    if (body) headers["content-type"] = "application/json";
    if (etag) headers["if-none-match"] = etag;
    const { signal, timeout } = this.#transport;
    const request = { method, headers, body: body && JSON.stringify(body), signal, timeout };
    const delays = brief ? RETRY_DELAYS_S.slice(0, BRIEF_RETRIES) : RETRY_DELAYS_S;
    const outcome = await retry(
      () => this.#attempt(path, request),
      (result, retries) => {
        const response = result instanceof Response ? result : null;
        if (response && !isTransient(response)) {
          if (this.#vain) this.#transport.onRetry(null);
          this.#vain = false;
          return null;
        }
        this.#vain = true;
        const asked = response ? retryAfter(response) : 0;
        // An exhausted hourly quota takes too long to wait for. So does a silent service, if the caller can continue.
        const hopeless = asked > MAX_RETRY_AFTER_MS || (brief && result instanceof OfflineError && result.silent);
        if (retries === delays.length || hopeless) return null;
        this.#transport.onRetry({ attempt: retries + 1 });
        return asked || 1000 * delays[retries];
      },
      async (wait) => {
        await this.#transport.wait(wait);
        signal?.throwIfAborted();
      },
    );
    if (outcome instanceof OfflineError) throw outcome;
    if (outcome.ok || outcome.status === 304) return outcome;
    throw new ApiError(outcome.status, await problem(outcome));
  }

  /**
   * The complete answer: if the transfer breaks off, it is requested again.
   * @param {string} path @param {RequestInit & {timeout?: number}} request @returns {Promise<Response | OfflineError>}
   */
  async #attempt(path, request) {
    try {
      const response = await this.#transport.fetch(this.#base + path, request);
      const body = await readable(response.arrayBuffer());
      const { status, statusText, headers } = response;
      return new Response(body.byteLength > 0 ? body : null, { status, statusText, headers });
    } catch (error) {
      if (error instanceof OfflineError) return error;
      throw error;
    }
  }

  /** @param {Parameters<Api["send"]>} request @returns {Promise<any>} the body */
  async json(...request) {
    const response = await this.send(...request);
    return response.status === 204 ? null : response.json();
  }
}

/**
 * Sends a request with the pages' token.
 * @param {string} method @param {string} path @param {Parameters<Api["send"]>[3]} [options]
 * @param {Partial<Transport>} [transport]
 * @returns {Promise<Response>} rejects as `Api.send` and `loadSettings` do
 */
export async function ask(method, path, options, transport) {
  const { api, token } = await loadSettings();
  return new Api(api, transport).send(method, path, token, options);
}

/** @param {Parameters<typeof ask>} request @returns {Promise<any>} the body */
export const askJson = async (...request) => (await ask(...request)).json();

/** @param {Response} response */
async function problem(response) {
  const text = await response.text();
  try {
    return JSON.parse(text);
  } catch (error) {
    if (error instanceof SyntaxError) return {}; // a proxy's page, which says nothing useful
    throw error;
  }
}
