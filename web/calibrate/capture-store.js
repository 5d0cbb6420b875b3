// What a capture has so far, kept on this device: a reload, a crash or a flat battery loses nothing.

/**
 * @typedef {import("../lib/session.js").Kept} Kept
 * @typedef {Kept & {time: number}} Dated ms since 1970, when it was saved
 *
 * @typedef {object} CaptureStore
 * @property {(about: string) => Promise<Kept | null>} load
 * @property {(except?: Set<string>) => Promise<Kept | null>} last the one that was saved last; except: what those are about that others have
 * @property {(kept: Kept) => Promise<boolean>} save false: it could not be kept, the storage is full or refused
 * @property {(about: string) => Promise<void>} remove
 */

const NAME = "calibdb";
const STORE = "captures";
const OLD = 24 * 3600 * 1000; // ms; nobody goes on with yesterday's capture

/**
 * @param {IDBFactory | undefined} factory @param {() => number} now ms
 * @returns {CaptureStore} one that keeps nothing where the browser refuses
 */
export function openCaptureStore(factory = globalThis.indexedDB, now = Date.now) {
  /** @type {Promise<IDBDatabase | null> | null} */
  let opening = null;
  const database = () => (opening ??= open(factory).catch(refused));
  /** @type {CaptureStore} */
  const captureStore = {
    async load(about) {
      const store = (await database())?.transaction(STORE).objectStore(STORE);
      const kept = store ? await done(store.get(about)).catch(refused) : null;
      return kept && now() - kept.time < OLD ? kept : null;
    },
    async last(except = new Set()) {
      const store = (await database())?.transaction(STORE).objectStore(STORE);
      const all = /** @type {Dated[]} */ ((store && (await done(store.getAll()).catch(refused))) ?? []);
      const fresh = all.filter(({ time }) => now() - time < OLD).sort((a, b) => b.time - a.time);
      for (const { about, time } of all) if (now() - time >= OLD) await captureStore.remove(about);
      return fresh.find(({ about }) => !except.has(about)) ?? null;
    },
    async save(kept) {
      const base = await database();
      if (!base) return false;
      try {
        await done(base.transaction(STORE, "readwrite").objectStore(STORE).put({ ...kept, time: now() }));
        return true;
      } catch (error) {
        refused(error);
        return false;
      }
    },
    async remove(about) {
      const base = await database();
      if (base) await done(base.transaction(STORE, "readwrite").objectStore(STORE).delete(about)).catch(refused);
    },
  };
  return captureStore;
}

/** @param {IDBFactory | undefined} factory @returns {Promise<IDBDatabase | null>} */
async function open(factory) {
  if (!factory) return null;
  const request = factory.open(NAME, 1);
  request.onupgradeneeded = () => request.result.createObjectStore(STORE, { keyPath: "about" });
  return done(request);
}

/** A browser that has no room, or keeps nothing for pages, says so by DOMExceptions. @param {unknown} error */
function refused(error) {
  if (!(error instanceof DOMException)) throw error;
  console.info("not kept on this device:", error.name);
  return null;
}

/** @template T @param {IDBRequest<T>} request @returns {Promise<T>} */
function done(request) {
  return new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error);
  });
}
