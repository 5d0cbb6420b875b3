// Requests that create and manage tokens. They are never retried: a retry might create a second token.
import { ApiError } from "../lib/api.js";
import { reach, readable } from "../lib/network.js";

/** @import { TokenCreated, TokenRotated } from "../vendor/api.js" */

/**
 * @typedef {import("../vendor/api.js").ManagedToken} ManagedToken
 */

/** The service refused a request about a token. */
export class ManagementError extends ApiError {
  /**
   * @param {number} status
   * @param {{type?: string, title?: string, detail?: string, errors?: {field: string, detail: string}[]}} problem
   * @param {number | null} retryAfter seconds
   */
  constructor(status, problem, retryAfter) {
    super(status, problem);
    this.name = "ManagementError";
    this.fields = problem.errors ?? [];
    this.retryAfter = retryAfter;
  }
}

/** @param {string} api @param {string[]} origins @returns {Promise<TokenCreated>} */
export const create = (api, origins) => send(api, "POST", "/tokens", "", { origins });

/** @param {string} api @param {string} secret management token @returns {Promise<ManagedToken>} */
export const show = (api, secret) => send(api, "GET", "/tokens/self", secret);

/**
 * @param {string} api
 * @param {string} secret
 * @param {{origins?: string[], name?: string}} change
 * @returns {Promise<ManagedToken>}
 */
export const change = (api, secret, change) => send(api, "PATCH", "/tokens/self", secret, change);

/** @param {string} api @param {string} secret @returns {Promise<ManagedToken>} */
export const verify = (api, secret) => send(api, "POST", "/tokens/self/verify", secret);

/** @param {string} api @param {string} secret @param {number} grace_s seconds @returns {Promise<TokenRotated>} */
export const rotate = (api, secret, grace_s) => send(api, "POST", "/tokens/self/rotate", secret, { grace_s });

/** @param {string} api @param {string} secret @returns {Promise<null>} */
export const revoke = (api, secret) => send(api, "DELETE", "/tokens/self", secret);

/**
 * @param {string} api
 * @param {string} method
 * @param {string} path
 * @param {string} secret
 * @param {object} [body]
 * @returns {Promise<any>}
 */
async function send(api, method, path, secret, body) {
  /** @type {Record<string, string>} */
  const headers = { accept: "application/json" };
  if (secret) headers.authorization = `Bearer ${secret}`;
  if (body) headers["content-type"] = "application/json";
  const response = await reach(api + path, { method, headers, body: body && JSON.stringify(body) });
  const text = await readable(response.text());
  const json = /json/.test(response.headers.get("content-type") ?? "");
  const content = json && text ? JSON.parse(text) : null;
  if (response.ok && (content || response.status === 204)) return content;
  const wait = Number(response.headers.get("retry-after"));
  throw new ManagementError(response.ok ? 502 : response.status, content ?? {}, wait > 0 ? wait : null);
}
