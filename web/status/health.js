// State of the service: the response of `/healthz?deep=1`, the page's own checks, and the verdict from both.
import { OfflineError, reach, readable } from "../lib/network.js";

/** @import { CanaryRun, PartHealth } from "../vendor/api.js" */

/**
 * @typedef {"ok" | "failed" | "unknown"} State
 * @typedef {"pages" | "functions" | PartHealth["part"] | "canary"} Name
 * @typedef {{name: Name, state: State, latency: number | null, words: string | null, at?: number}} Row words: of the
 *   canary, instead of its state; at: unix seconds
 * @typedef {{ok: boolean, status: number, ms: number, body: any}} Heard status: 0 where nothing answered
 * @typedef {"all" | "edge" | "some" | "canary" | "functions" | "nothing"} Verdict
 */

const TIMEOUT_MS = 15_000; // the parts have 11 s together
const LATE_S = 25 * 60; // a canary runs every ten minutes
const PARTS = /** @type {const} */ (["table", "bucket", "solver", "edge"]);

/** @param {URL} address @param {() => number} [clock] ms @returns {Promise<Heard>} whatever comes of it */
export async function hear(address, clock = () => performance.now()) {
  const start = clock();
  try {
    const response = await reach(address, { timeout: TIMEOUT_MS, cache: "no-store" });
    const text = await readable(response.text());
    return { ok: response.ok, status: response.status, ms: clock() - start, body: parsed(text) };
  } catch (error) {
    if (!(error instanceof OfflineError)) throw error;
    return { ok: false, status: 0, ms: clock() - start, body: null };
  }
}

/** @param {string} text */
function parsed(text) {
  try {
    return JSON.parse(text);
  } catch (error) {
    if (!(error instanceof SyntaxError)) throw error;
    return null; // a gateway's own page
  }
}

/**
 * Rows to show, and what they come to.
 * @param {Heard} health of `/healthz?deep=1`
 * @param {Heard} settings of `/config.json`, which no function answers
 * @param {number} now unix seconds
 * @returns {{rows: Row[], verdict: Verdict}}
 */
export function stateOf(health, settings, now) {
  const pages = settings.ok && settings.body?.api !== undefined;
  /** @type {PartHealth[] | null} */
  const parts = Array.isArray(health.body?.parts) ? health.body.parts : null;
  /** @type {Row[]} */
  const rows = [
    { name: "pages", state: pages ? "ok" : "failed", latency: pages ? settings.ms : null, words: null },
    { name: "functions", state: parts ? "ok" : "failed", latency: parts ? health.ms : null, words: null },
    ...PARTS.map((name) => partRow(name, parts)),
  ];
  /** @type {CanaryRun | null} */
  const canary = parts ? (health.body.canary ?? null) : null;
  if (canary) rows.push(canaryRow(canary, now));
  return { rows, verdict: verdictOf(rows, pages, parts !== null) };
}

/** @param {typeof PARTS[number]} name @param {PartHealth[] | null} parts @returns {Row} */
function partRow(name, parts) {
  const part = parts?.find((each) => each.part === name);
  if (!part) return { name, state: "unknown", latency: null, words: null };
  return { name, state: part.ok ? "ok" : "failed", latency: part.latency_ms, words: null };
}

/** @param {CanaryRun} canary @param {number} now @returns {Row} */
function canaryRow({ ok, at, took_ms: took, failed_at: step }, now) {
  if (!ok) return { name: "canary", state: "failed", latency: null, words: step ?? null, at };
  const late = now - at > LATE_S;
  return {
    name: "canary",
    state: late ? "unknown" : "ok",
    latency: late ? null : took,
    words: late ? "late" : null,
    at,
  };
}

/** @param {Row[]} rows @param {boolean} pages @param {boolean} functions @returns {Verdict} */
function verdictOf(rows, pages, functions) {
  if (!functions) return pages ? "functions" : "nothing";
  const failed = rows.filter(({ state }) => state === "failed").map(({ name }) => name);
  if (failed.length === 0) return "all";
  if (failed.every((name) => name === "canary")) return "canary";
  return failed.every((name) => name === "edge" || name === "pages") ? "edge" : "some";
}
