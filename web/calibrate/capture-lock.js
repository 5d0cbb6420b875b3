// One capture belongs to one tab: two that sent views of the same camera to the same session would undo each other's.

const NAME = "calibdb capture ";
const TURN = 250; // ms
const GRACE = 6; // turns in which a page that is just left lets go; time that this page was busy for itself is none of them

/**
 * Takes a capture for this tab.
 * @param {string} about what the capture is of @param {AbortSignal} signal after which it is let go
 * @returns {Promise<boolean>} false: another tab has it. True where the browser cannot tell
 */
export function acquireLock(about, signal) {
  if (!navigator.locks || signal.aborted) return Promise.resolve(true);
  const over = new AbortController();
  let turns = 0;
  const timer = setInterval(() => ++turns === GRACE && over.abort(), TURN);
  return /** @type {Promise<boolean>} */ (new Promise((resolve, reject) => {
    navigator.locks.request(NAME + about, { signal: over.signal }, () => {
      resolve(true);
      if (!signal.aborted) return new Promise((free) => signal.addEventListener("abort", free));
    }).catch((error) => (error instanceof DOMException ? resolve(false) : reject(error)));
  })).finally(() => clearInterval(timer));
}

/** What captures go on now are about, in whichever tab. @returns {Promise<Set<string>>} */
export async function heldLocks() {
  const { held = [] } = (await navigator.locks?.query()) ?? {};
  return new Set(held.map(({ name = "" }) => name).filter((name) => name.startsWith(NAME)).map((name) => name.slice(NAME.length)));
}
