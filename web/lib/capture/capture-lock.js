// Lock on a capture (Web Locks): two tabs that sent views to one session would undo each other's.

const PREFIX = "calibdb capture ";
const TURN_MS = 250;
// in which a page that is being left releases its lock; time for which this page is busy does not count
const MAX_TURNS = 6;

/**
 * Locks a capture for this tab.
 * @param {string} key of the capture @param {AbortSignal} signal releases the lock
 * @returns {Promise<boolean>} false: another tab holds it. True where the browser has no locks
 */
export function acquireLock(key, signal) {
  if (!navigator.locks || signal.aborted) return Promise.resolve(true);
  const timeout = new AbortController();
  let turns = 0;
  const timer = setInterval(() => ++turns === MAX_TURNS && timeout.abort(), TURN_MS);
  return /** @type {Promise<boolean>} */ (
    new Promise((resolve, reject) => {
      navigator.locks
        .request(PREFIX + key, { signal: timeout.signal }, () => {
          resolve(true);
          if (!signal.aborted) return new Promise((release) => signal.addEventListener("abort", release));
        })
        .catch((error) => (error instanceof DOMException ? resolve(false) : reject(error)));
    })
  ).finally(() => clearInterval(timer));
}

/** Keys of the captures that are locked, in whichever tab. @returns {Promise<Set<string>>} */
export async function heldLocks() {
  const { held = [] } = (await navigator.locks?.query()) ?? {};
  const names = held.map(({ name = "" }) => name).filter((name) => name.startsWith(PREFIX));
  return new Set(names.map((name) => name.slice(PREFIX.length)));
}
