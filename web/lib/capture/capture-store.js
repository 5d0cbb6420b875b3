// Store of unfinished captures on this device (IndexedDB): a reload, a crash or a flat battery loses nothing. Locks on
// captures (Web Locks): two tabs that sent views to one session would undo each other's.

/** @import { SavedCapture } from "../session.js" */

/**
 * @template {{about: string}} [Capture=SavedCapture] about: its key
 * @typedef {object} CaptureStore
 * @property {(about: string) => Promise<Capture | null>} load
 * @property {(except?: Set<string>) => Promise<Capture | null>} last the one that was saved last; except: keys to leave
 *   out
 * @property {(capture: Capture) => Promise<boolean>} save false: the storage is full or refused
 * @property {(about: string) => Promise<void>} remove
 */

const CAMERAS = "calibdb"; // database of the captures of one camera
const OBJECT_STORE = "captures";
const MAX_AGE_MS = 24 * 3600 * 1000; // yesterday's capture is not worth resuming

/**
 * @template {{about: string}} [Capture=SavedCapture]
 * @param {string} name of the database: each kind of captures has its own
 * @returns {CaptureStore<Capture>} an empty one where the browser refuses
 */
export function openCaptureStore(name = CAMERAS) {
  /** @type {Promise<IDBDatabase | null> | null} */
  let opening = null;
  const database = () => (opening ??= open(name).catch(handleRefusal));
  /** @type {CaptureStore<Capture>} */
  const captureStore = {
    async load(about) {
      const store = (await database())?.transaction(OBJECT_STORE).objectStore(OBJECT_STORE);
      const saved = store ? await result(store.get(about)).catch(handleRefusal) : null;
      return saved && Date.now() - saved.time < MAX_AGE_MS ? saved : null;
    },
    async last(except = new Set()) {
      const store = (await database())?.transaction(OBJECT_STORE).objectStore(OBJECT_STORE);
      const all = /** @type {(Capture & {time: number})[]} */ (
        (store && (await result(store.getAll()).catch(handleRefusal))) ?? []
      );
      const fresh = all.filter(({ time }) => Date.now() - time < MAX_AGE_MS).sort((a, b) => b.time - a.time);
      for (const { about, time } of all) if (Date.now() - time >= MAX_AGE_MS) await captureStore.remove(about);
      return fresh.find(({ about }) => !except.has(about)) ?? null;
    },
    async save(capture) {
      const base = await database();
      if (!base) return false;
      try {
        const store = base.transaction(OBJECT_STORE, "readwrite").objectStore(OBJECT_STORE);
        await result(store.put({ ...capture, time: Date.now() }));
        return true;
      } catch (error) {
        handleRefusal(error);
        return false;
      }
    },
    async remove(about) {
      const store = (await database())?.transaction(OBJECT_STORE, "readwrite").objectStore(OBJECT_STORE);
      if (store) await result(store.delete(about)).catch(handleRefusal);
    },
  };
  return captureStore;
}

/** @param {string} name @returns {Promise<IDBDatabase | null>} */
async function open(name) {
  if (!globalThis.indexedDB) return null;
  const request = indexedDB.open(name, 1);
  request.onupgradeneeded = () => request.result.createObjectStore(OBJECT_STORE, { keyPath: "about" });
  return result(request);
}

/** Browsers without room, or without storage for pages, raise DOMExceptions. @param {unknown} error */
function handleRefusal(error) {
  if (!(error instanceof DOMException)) throw error;
  console.info("not saved on this device:", error.name);
  return null;
}

/** @template T @param {IDBRequest<T>} request @returns {Promise<T>} */
function result(request) {
  return new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error);
  });
}

const LOCK_PREFIX = "calibdb capture ";
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
        .request(LOCK_PREFIX + key, { signal: timeout.signal }, () => {
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
  const names = held.map(({ name = "" }) => name).filter((name) => name.startsWith(LOCK_PREFIX));
  return new Set(names.map((name) => name.slice(LOCK_PREFIX.length)));
}
