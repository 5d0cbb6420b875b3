// Service worker: caches the pages' files under the hashes of their contents. Nothing of the API is ever cached.
//
// `shell.json` names every file with the hash of its content; the server or the deployment writes it
// (infra/web_build/root_files.py). A visit gets the files of one such list, all old or all new: the next list
// applies only once all of its files are cached. OpenCV is cached when it is first used, or while a page is open that
// will use it. On localhost, where pages are developed, the network comes first and the cache is only its fallback.

/** @typedef {{version: string, files: Record<string, string>, late: string[]}} Shell late: kept when used */

/** @type {any} a ServiceWorkerGlobalScope, which the page's types do not know */
const worker = self;
const BASE = new URL("./", location.href);
const SHELL = new URL("shell.json", BASE).href;
const CACHE = "calibdb";
const OFFLINE = "offline.html"; // shown instead of a page that is not kept
const DEVELOPED = ["localhost", "127.0.0.1", "[::1]"].includes(location.hostname);
const LANGUAGE = /^(de|uk)\//; // folders of pages
const DETECTING = /\/(calibrate|rig|photos|ar)\/$/;

/** The file a request is for, "" and "board/" being pages; null where it is none of ours. @param {Request} request */
function fileOf({ method, url, headers }) {
  const { origin, pathname } = new URL(url);
  if (method !== "GET" || origin !== BASE.origin || !pathname.startsWith(BASE.pathname) || headers.has("authorization"))
    return null;
  const path = pathname.slice(BASE.pathname.length);
  if (path === "" || path.endsWith("/")) return `${path}index.html`;
  return /\.(html|js|css|svg|json|woff2|wasm)$/.test(path) && !path.startsWith("known/") ? path : null;
}

/** @param {string} name @param {string} hash */
const keyOf = (name, hash) => `${new URL(name, BASE).href}?sha256=${hash}`;

/** The list that visits are served from. @param {Cache} cache @returns {Promise<Shell | null>} */
async function current(cache) {
  const kept = await cache.match(SHELL);
  return kept ? kept.json() : null;
}

/** True if a response has the content that the list names. @param {Response} response @param {string} hash */
async function isContent(response, hash) {
  const digest = await crypto.subtle.digest("SHA-256", await response.arrayBuffer());
  return Array.from(new Uint8Array(digest), (byte) => byte.toString(16).padStart(2, "0")).join("") === hash;
}

/** Fetches a file unless it is here. @param {Cache} cache @param {string} name @param {string} hash */
async function keep(cache, name, hash) {
  const key = keyOf(name, hash);
  if (await cache.match(key)) return;
  const response = await fetch(new URL(name, BASE), { cache: "no-cache" });
  // A deployment is in progress: the next visit tries the whole list again.
  if (!response.ok || !(await isContent(response.clone(), hash)))
    throw new TypeError(`${name} is not what the list says`);
  await cache.put(key, response);
}

/** Takes up the newest list, whole or not at all. */
async function update() {
  const response = await fetch(SHELL, { cache: "no-store" });
  if (!response.ok) return;
  const cache = await caches.open(CACHE);
  const before = await current(cache);
  const pages = await worker.clients.matchAll({ type: "window", includeUncontrolled: true });
  /**
   * True if a file's language is in use: English always, another one while a page in it is open.
   * @param {string} name
   */
  const isSpoken = (name) => {
    const folder = LANGUAGE.exec(name)?.[0];
    return !folder || pages.some((/** @type {{url: string}} */ { url }) => url.startsWith(`${BASE.href}${folder}`));
  };
  /** @type {Shell} */
  const shell = await response.clone().json();
  if (shell.version !== before?.version) {
    const now = Object.entries(shell.files).filter(([name]) => !shell.late.includes(name) && isSpoken(name));
    await Promise.all(now.map(([name, hash]) => keep(cache, name, hash)));
    await cache.put(SHELL, response);
    // Pages that are open still go by the list before.
    const wanted = new Set([
      SHELL,
      ...[shell, before].flatMap((list) => Object.entries(list?.files ?? {}).map(([name, hash]) => keyOf(name, hash))),
    ]);
    for (const { url } of await cache.keys()) if (!wanted.has(url)) await cache.delete(url);
  }
  await Promise.all(
    Object.entries(shell.files)
      .filter(([name]) => LANGUAGE.test(name) && isSpoken(name))
      .map(([name, hash]) => keep(cache, name, hash)),
  );
  if (pages.some((/** @type {{url: string}} */ { url }) => DETECTING.test(new URL(url).pathname))) {
    await Promise.all(shell.late.map((name) => keep(cache, name, shell.files[name])));
  }
}

/** Ignores a lack of network or storage: the cache stays as it is. */
async function tryUpdate() {
  try {
    await update();
  } catch (error) {
    if (!(error instanceof TypeError) && !(error instanceof DOMException)) throw error;
    console.info("kept files stay as they are:", error.message);
  }
}

/** @param {Request} request @param {string} name */
async function answer(request, name) {
  const cache = await caches.open(CACHE);
  const files = (await current(cache))?.files ?? {};
  const hash = files[name];
  const kept = hash && (await cache.match(keyOf(name, hash)));
  if (!kept) {
    const instead =
      request.mode === "navigate" && files[OFFLINE] ? await cache.match(keyOf(OFFLINE, files[OFFLINE])) : null;
    return instead ? fetch(request).catch(() => instead) : fetch(request);
  }
  return DEVELOPED ? fetch(request).catch(() => kept) : kept;
}

worker.addEventListener("install", (/** @type {any} */ event) => {
  worker.skipWaiting();
  event.waitUntil(tryUpdate());
});
worker.addEventListener("activate", (/** @type {any} */ event) => event.waitUntil(worker.clients.claim()));
worker.addEventListener("fetch", (/** @type {any} */ event) => {
  const name = fileOf(event.request);
  if (name === null || name === "config.json" || name === "shell.json" || name === "sw.js") return;
  event.respondWith(answer(event.request, name));
  if (event.request.mode === "navigate") event.waitUntil(tryUpdate());
});
