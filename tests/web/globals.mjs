// Globals of a browser that Node lacks: set for one test, because all tests run in one process.

/** Descriptors by name, undefined for what Node lacks. @type {Map<string, PropertyDescriptor | undefined>} */
const originals = new Map();

/**
 * @param {import("node:test").TestContext} t the test after which they are as before
 * @param {Record<string, unknown>} globals by name
 */
export function setGlobals(t, globals) {
  for (const [name, value] of Object.entries(globals)) {
    if (!originals.has(name)) originals.set(name, Object.getOwnPropertyDescriptor(globalThis, name));
    const original = originals.get(name);
    Object.defineProperty(globalThis, name, { value, configurable: true, writable: true });
    t.after(() => (original ? Object.defineProperty(globalThis, name, original) : delete globalThis[name]));
  }
}

/** A browser's storage. @param {Map<string, string>} kept its content */
export const storageOf = (kept) => ({
  getItem: (name) => kept.get(name) ?? null,
  setItem: (name, value) => void kept.set(name, value),
  removeItem: (name) => void kept.delete(name),
});

/** A storage without room. */
export const FULL = {
  getItem: () => null,
  setItem() {
    throw new DOMException("full", "QuotaExceededError");
  },
};

/** The page's storage. @param {import("node:test").TestContext} t @returns {Map<string, string>} what it keeps */
export function keepHere(t) {
  const kept = new Map();
  setGlobals(t, { localStorage: storageOf(kept) });
  return kept;
}

/** One answer after the other, the last again and again; errors are thrown. */
export function inTurn(answers) {
  const next = answers.length > 1 ? answers.shift() : answers[0];
  if (next instanceof Error) throw next;
  return next;
}

/**
 * An answer of the service.
 * @param {number} status @param {object | null} body @param {Record<string, string>} headers
 */
export const json = (status, body, headers = {}) =>
  new Response(body && JSON.stringify(body), { status, headers: { "content-type": "application/json", ...headers } });
