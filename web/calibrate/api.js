// HTTP to the service: bearer credentials, problems as errors, patience when the network fails.

import { OfflineError, reach } from "../network.js";

export { OfflineError };

/**
 * @typedef {object} Transport what the outside world gives; replaced in tests
 * @property {typeof reach} fetch rejects with OfflineError when there is no network, and only then we may try again
 * @property {(ms: number) => Promise<void>} wait
 * @property {AbortSignal} [signal] after which nothing more is asked
 * @property {(patience: {attempt: number} | null) => void} onPatience told before each new attempt, and when it got through
 */

/** Seconds between attempts: a minute in all, about as long as a person would wait. */
const PAUSES = [0.5, 1, 2, 4, 8, 15, 30];
/** Who can go on without an answer waits for two seconds. */
const SHORT_PAUSES = 2;
/** Seconds that the service may ask to be left alone for. */
const LONGEST = 60;
const PASSING = new Set([429, 500, 502, 503, 504]);

/** The service's answer was no. */
export class ApiError extends Error {
  /** @param {number} status @param {{type?: string, title?: string, detail?: string, errors?: {field: string, detail: string}[]}} problem */
  constructor(status, problem) {
    const fields = (problem.errors ?? []).map(({ field, detail }) => `${field}: ${detail}`).join("; ");
    super([problem.detail ?? problem.title ?? `The service answered ${status}.`, fields].filter(Boolean).join(" "));
    this.name = "ApiError";
    this.status = status;
    /** What kind of problem, "session-expired". */
    this.kind = (problem.type ?? "").split(/[/:]/).at(-1) ?? "";
  }

  /** Is this likely to pass by itself? */
  get passing() {
    return PASSING.has(this.status);
  }
}

export class Api {
  #base;
  #transport;

  /** @param {string} base address of the API, "/v1" @param {Partial<Transport>} [transport] */
  constructor(base, transport = {}) {
    this.#base = base.replace(/\/$/, "");
    this.#transport = {
      fetch: reach,
      wait: (/** @type {number} */ ms) => new Promise((/** @type {(value: void) => void} */ done) => setTimeout(done, ms)),
      onPatience: () => {},
      ...transport,
    };
  }

  /**
   * @param {string} method @param {string} path "/session" @param {string} credential
   * @param {{body?: object, accept?: string, brief?: boolean}} [options] brief: two seconds of patience, not a minute
   * @returns {Promise<Response>} one that is ok; rejects with ApiError or OfflineError
   *
   * All calls are safe to repeat: the service answers the same view again in the same way.
   */
  async send(method, path, credential, { body, accept = "application/json", brief = false } = {}) {
    /** @type {HeadersInit} */
    const headers = { authorization: `Bearer ${credential}`, accept };
    if (body) headers["content-type"] = "application/json";
    const { signal } = this.#transport;
    const request = { method, headers, body: body && JSON.stringify(body), signal };
    const pauses = brief ? PAUSES.slice(0, SHORT_PAUSES) : PAUSES;
    for (let attempt = 0; ; attempt++) {
      const response = await this.#transport.fetch(this.#base + path, request).catch(noNetwork);
      if (response && !PASSING.has(response.status)) {
        if (attempt > 0) this.#transport.onPatience(null);
        if (response.ok) return response;
        throw new ApiError(response.status, await problem(response));
      }
      const asked = Number(response?.headers.get("retry-after"));
      // A used-up hour is not waited for: nobody stands there so long.
      if (attempt === pauses.length || asked > LONGEST) {
        if (response) throw new ApiError(response.status, await problem(response));
        throw new OfflineError();
      }
      this.#transport.onPatience({ attempt: attempt + 1 });
      await this.#transport.wait(1000 * (asked > 0 ? asked : pauses[attempt]));
      signal?.throwIfAborted();
    }
  }

  /** @param {Parameters<Api["send"]>} request @returns {Promise<any>} the body */
  async json(...request) {
    const response = await this.send(...request);
    return response.status === 204 ? null : response.json();
  }
}

/** @param {unknown} error */
function noNetwork(error) {
  if (error instanceof OfflineError) return null;
  throw error;
}

/** @param {Response} response */
async function problem(response) {
  const text = await response.text();
  try {
    return JSON.parse(text);
  } catch (error) {
    if (error instanceof SyntaxError) return {}; // a proxy's page, of no use to anybody
    throw error;
  }
}
