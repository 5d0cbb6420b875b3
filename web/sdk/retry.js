// Retries: which failures of a service may pass, and the loop that tries again.

/**
 * A service that is asked too often (429) or that failed for now; its own errors (500) pass too, for all calls are
 * idempotent.
 */
const TRANSIENT_STATUSES = [429, 500, 502, 503, 504];

/** @param {{status: number}} response */
export const isTransient = ({ status }) => TRANSIENT_STATUSES.includes(status);

/** Milliseconds that the service asks to wait; 0 where it does not say. @param {Response} response */
export const retryAfter = ({ headers }) => Math.max(0, 1000 * Number(headers.get("retry-after"))) || 0;

/**
 * Repeats an attempt until its outcome is final.
 * @template T
 * @param {() => Promise<T>} attempt
 * @param {(outcome: T, retries: number) => number | null} delay ms to wait before the next attempt; null: the outcome
 *   is final
 * @param {(milliseconds: number) => Promise<void>} pause
 * @returns {Promise<T>}
 */
export async function retry(attempt, delay, pause) {
  for (let retries = 0; ; retries++) {
    const outcome = await attempt();
    const wait = delay(outcome, retries);
    if (wait === null) return outcome;
    await pause(wait);
  }
}
