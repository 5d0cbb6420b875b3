// Store of unfinished captures on this device (IndexedDB): a reload, a crash or a flat battery loses nothing.

/**
 * @typedef {import("../session.js").SavedCapture} SavedCapture
 * @typedef {SavedCapture & {time: number}} Dated ms since 1970, when it was saved
 *
 * @typedef {object} CaptureStore
 * @property {(about: string) => Promise<SavedCapture | null>} load
 * @property {(except?: Set<string>) => Promise<SavedCapture | null>} last the one that was saved last; except: keys to leave out
 * @property {(capture: SavedCapture) => Promise<boolean>} save false: the storage is full or refused
 * @property {(about: string) => Promise<void>} remove
 */

const DATABASE = "calibdb";
const OBJECT_STORE = "captures";
const MAX_AGE_MS = 24 * 3600 * 1000; // nobody resumes yesterday's capture

/**
 * @param {IDBFactory | undefined} factory @param {() => number} now ms
 * @returns {CaptureStore} an empty one where the browser refuses
 */
export function openCaptureStore(factory = globalThis.indexedDB, now = Date.now) {
  /** @type {Promise<IDBDatabase | null> | null} */
  let opening = null;
  const database = () => (opening ??= open(factory).catch(handleRefusal));
  /** @type {CaptureStore} */
  const captureStore = {
    async load(about) {
      const store = (await database())?.transaction(OBJECT_STORE).objectStore(OBJECT_STORE);
      const saved = store ? await result(store.get(about)).catch(handleRefusal) : null;
      return saved && now() - saved.time < MAX_AGE_MS ? saved : null;
    },
    async last(except = new Set()) {
      const store = (await database())?.transaction(OBJECT_STORE).objectStore(OBJECT_STORE);
      const all = /** @type {Dated[]} */ ((store && (await result(store.getAll()).catch(handleRefusal))) ?? []);
      const fresh = all.filter(({ time }) => now() - time < MAX_AGE_MS).sort((a, b) => b.time - a.time);
      for (const { about, time } of all) if (now() - time >= MAX_AGE_MS) await captureStore.remove(about);
      return fresh.find(({ about }) => !except.has(about)) ?? null;
    },
    async save(capture) {
      const base = await database();
      if (!base) return false;
      try {
        const store = base.transaction(OBJECT_STORE, "readwrite").objectStore(OBJECT_STORE);
        await result(store.put({ ...capture, time: now() }));
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

/** @param {IDBFactory | undefined} factory @returns {Promise<IDBDatabase | null>} */
async function open(factory) {
  if (!factory) return null;
  const request = factory.open(DATABASE, 1);
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
