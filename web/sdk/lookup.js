// Lookup of an open camera's calibration, cached as long as the tab.
import { Calibration, Estimate } from "./calibration.js";
import { keyOf } from "./key.js";
import { askEdge } from "./edge.js";
import { LookupError, address, ask, calibrationIn } from "./request.js";

/**
 * @typedef {import("./key.js").CameraKey} CameraKey
 * @typedef {import("./calibration.js").CalibrationData} CalibrationData
 * @typedef {import("./calibration.js").EstimateData} EstimateData
 *
 * @typedef {object} Answer
 * @property {Calibration | null} calibration null: nothing is known that is good enough
 * @property {string | null} guidanceUrl where this camera can be calibrated, then
 * @property {string | null} reason "unknown_camera", "too_few", "disagree", "few_contributors" or "imprecise", as the
 *   service says; "other_size" where
 *   `exact`, "too_uncertain" where `maxError` asked for more than is known
 * @property {Estimate | null} estimate where nothing reliable is known: what is likely, and how likely
 * @property {Calibration | Estimate | null} camera to draw with: the calibration; the estimate, too, if `accept` is
 *   "estimate"
 *
 * @typedef {object} LookupOptions
 * @property {"calibration" | "estimate"} [accept] "estimate": `camera` may be an estimate
 * @property {string} [model] distortion model, "rectilinear" by default
 * @property {string} [device] model identifier of the phone, "iPhone17,3", if the application knows it
 * @property {View[]} [views] one to five views of `board`: they pick the mode of a camera whose calibrations disagree
 * @property {Record<string, unknown>} [board] the board of the views, as in the API; calibDB's own by default
 * @property {boolean} [exact] nothing but what is known of this very size, or verified for it
 * @property {number} [maxError] px: largest uncertainty, and largest difference between the calibrations that agree
 * @property {(answer: Answer) => void} [onNeedCalibration] called if no calibration is known
 * @property {Cache | null} [cache] the tab's `sessionStorage` by default, in a worker the worker's memory; null: none
 * @property {Offline} [bundle] calibrations that came with the application, asked first; see bundle.js
 *
 * @typedef {{ids: number[], points: [number, number][]}} View corners of a board in one frame, px
 *
 * @typedef {{getItem: (name: string) => string | null, setItem: (name: string, value: string) => void}} Cache as a
 *   Storage
 *
 * @typedef {object} Offline
 * @property {(key: CameraKey, model: string) => CalibrationData | null} find
 *
 * @typedef {import("./request.js").RequestOptions} RequestOptions
 * @typedef {LookupOptions & (RequestOptions | Omit<RequestOptions, "token"> & {token?: string | undefined, bundle:
 *   Offline})} Options without a token only the bundle is asked
 */

/**
 * @typedef {{calibration: CalibrationData | null, guidanceUrl: string | null, reason: string | null, estimate?:
 *   EstimateData | null}} Found
 */

/** ms: a cached answer takes tens; a slower one is probably a miss. */
const EDGE_TIMEOUT_MS = 300;
/** ms for which the edge is not asked again about a camera that it did not know. */
const MISS_MS = 3_600_000;
/** @type {import("./edge.js").EdgeAnswer} */
const UNASKED = { outcome: "unasked", calibration: null };
/** ms between a lookup that failed, while a camera is watched, and the next. */
const WATCH_RETRY_MS = 30_000;

/** @type {Map<string, string>} */
const memory = new Map();
const worker = {
  getItem: (/** @type {string} */ name) => memory.get(name) ?? null,
  setItem: (/** @type {string} */ name, /** @type {string} */ value) => void memory.set(name, value),
};

/**
 * Looks up the calibration of a camera.
 * @param {MediaStreamTrack | CameraKey} source an open camera, or what identifies it
 * @param {Options} options
 * @returns {Promise<Answer>} rejects with LookupError, with a TypeError for a track that shows nothing, or as its
 *   signal says
 */
export async function lookup(source, options) {
  const {
    model = "rectilinear",
    accept = "calibration",
    device,
    views,
    board,
    exact = false,
    maxError = Infinity,
    onNeedCalibration,
    cache = tabs(),
    bundle,
    ...manner
  } = /** @type {Options} */ (options ?? {});
  const key = await keyOf(source, device);
  manner.signal?.throwIfAborted();
  const guidance = () => guidanceUrl(key, model, manner.api);
  const name = `calibdb ${JSON.stringify([address(manner.api).href, key, model])}`;
  const known = bundle?.find(key, model) ?? remembered(cache, name);
  /** @type {Found} */
  let answer = { calibration: known, guidanceUrl: null, reason: null };
  if (!known && bundle && !manner.token) answer = { ...answer, guidanceUrl: guidance(), reason: "unknown_camera" };
  else if (!known)
    answer = await fetchCalibration(
      key,
      model,
      /** @type {RequestOptions} */ (manner),
      missesOf(cache, name),
      views && { views, board },
    );
  if (answer.calibration && !known) keep(cache, name, answer.calibration);
  const enough = applyRequirements(answer, { accept, exact, maxError }, guidance);
  if (!enough.calibration) onNeedCalibration?.(enough);
  return enough;
}

/**
 * Looks a camera up, and again whenever its picture changes: another size, another zoom, a phone that is turned.
 * After a failure that may pass, it asks again every half minute.
 * @param {MediaStreamTrack} track
 * @param {Options} options its signal ends the watch, as the end of the track does
 * @param {(answer: Answer | Error) => void} onAnswer
 * @param {number} [every] ms between checks of a track whose browser sends no events
 * @returns {() => void} ends the watch
 */
export function watch(track, options, onAnswer, every = 500) {
  let shown = "";
  /** @type {AbortController | undefined} */
  let running;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let retry;
  const look = () => {
    if (track.readyState === "ended" || options.signal?.aborted) return stop();
    const { width, height, zoom } = /** @type {MediaTrackSettings & {zoom?: number}} */ (track.getSettings());
    const now = [width, height, zoom].join();
    if (!width || now === shown) return;
    shown = now;
    running?.abort();
    clearTimeout(retry);
    const own = (running = new AbortController());
    const tell = (/** @type {Answer | Error} */ answer) => own.signal.aborted || onAnswer(answer);
    lookup(track, { ...options, signal: own.signal }).then(tell, (error) => {
      if (error instanceof LookupError && (error.status === 0 || error.status === 429 || error.status >= 500)) {
        retry = setTimeout(() => {
          shown = "";
          look();
        }, WATCH_RETRY_MS);
      }
      tell(error);
    });
  };
  const timer = setInterval(look, every);
  const stop = () => {
    clearInterval(timer);
    track.removeEventListener("configurationchange", look);
    options.signal?.removeEventListener("abort", stop);
    running?.abort();
    clearTimeout(retry);
  };
  track.addEventListener("configurationchange", look);
  options.signal?.addEventListener("abort", stop);
  look();
  return stop;
}

/**
 * The page where a camera can be calibrated.
 * @param {CameraKey | null} key @param {string} model @param {string | URL} [api]
 */
export function guidanceUrl(key, model, api) {
  const url = new URL("../calibrate/", address(api));
  const { camera, platform, img_size: size, zoom } = key ?? {};
  const query = { camera, platform, img_size: size?.join("x"), zoom: zoom?.toString(), distortion_model: model };
  for (const [name, value] of Object.entries(query)) if (value) url.searchParams.set(name, value);
  return url.href;
}

/**
 * Asks the edge, and then the service. If the edge is slow, both are asked in parallel, and the first to know the
 * camera wins.
 * @param {CameraKey} key
 * @param {string} model
 * @param {RequestOptions} options
 * @param {Misses} misses
 * @param {object} [seen] views and their board
 * @returns {Promise<Found>}
 */
async function fetchCalibration(key, model, options, misses, seen) {
  const atEdge = misses.recent() ? Promise.resolve(UNASKED) : askEdge(key, model, options);
  const early = await within(EDGE_TIMEOUT_MS, atEdge);
  if (early?.calibration) return answerOf(early.calibration);
  if (early?.outcome === "missing") misses.keep();
  const enough = new AbortController();
  const signal = options.signal ? AbortSignal.any([options.signal, enough.signal]) : enough.signal;
  const service = askService(key, model, { ...options, signal }, seen);
  if (early) return service.catch((error) => Promise.reject(explain(error, early)));
  return new Promise((resolve, reject) => {
    atEdge.then(({ calibration }) => {
      if (!calibration) return;
      resolve(answerOf(calibration));
      enough.abort();
    }, reject);
    service.then(resolve, (error) => atEdge.then((late) => late.calibration || reject(explain(error, late)), reject));
  });
}

/**
 * @typedef {object} Misses what the tab remembers of a camera that the edge did not know
 * @property {() => boolean} recent @property {() => void} keep
 */

/** @param {Cache | null} cache @param {string} name @returns {Misses} */
function missesOf(cache, name) {
  const missed = `${name} missed`;
  return {
    recent: () => Math.abs(Date.now() - Number(cache?.getItem(missed) ?? 0)) < MISS_MS,
    keep: () => store(cache, missed, String(Date.now())),
  };
}

/** @param {CalibrationData} calibration @returns {Found} */
const answerOf = (calibration) => ({ calibration, guidanceUrl: null, reason: null });

/**
 * Result of a promise that settles in time; null where it takes longer.
 * @template T @param {number} milliseconds @param {Promise<T>} promise @returns {Promise<T | null>}
 */
function within(milliseconds, promise) {
  return new Promise((resolve, reject) => {
    const timer = setTimeout(() => resolve(null), milliseconds);
    promise.then(resolve, reject).finally(() => clearTimeout(timer));
  });
}

/**
 * The error of a service that fails while the edge works: the edge would have answered a known camera.
 * @param {unknown} error @param {import("./edge.js").EdgeAnswer} edge
 */
function explain(error, { outcome }) {
  if (!(error instanceof LookupError) || outcome !== "missing" || (error.status !== 0 && error.status < 500))
    return error;
  const text =
    "calibDB does not know this camera well enough to answer without its service, " +
    "which cannot be asked now: try again later";
  return new LookupError(text, error.status, { cause: error });
}

/**
 * @param {CameraKey} key @param {string} model @param {RequestOptions} options @param {object} [seen]
 * @returns {Promise<Found>}
 */
async function askService(key, model, options, seen) {
  // fetch() hides a redirect's Location, and browsers report a 404 as an error: so request an explicit miss.
  const asked = { ...key, distortion_model: model, redirect: false, miss: "ok", ...seen };
  const answer = await ask("lookup", { method: "POST", body: JSON.stringify(asked) }, options);
  const { calibration, guidance_url: guidanceUrl, reason = null, estimate = null } = answer.body;
  // 404: from a service that does not know `miss`.
  if (guidanceUrl && (answer.response.status === 404 || (answer.response.ok && calibration === null)))
    return { calibration: null, guidanceUrl, reason, estimate };
  return answerOf(calibrationIn(answer));
}

/**
 * Answer by the caller's requirements: adapted to the requested size if that is verified, null if it does not suffice.
 * @param {Found} answer
 * @param {{accept: string, exact: boolean, maxError: number}} requirements
 * @param {() => string} guidance
 * @returns {Answer}
 */
function applyRequirements(
  { calibration: known, guidanceUrl, reason, estimate: likely },
  { accept, exact, maxError },
  guidance,
) {
  const estimate = likely ? new Estimate(likely) : null;
  const missed = (/** @type {string | null} */ url, /** @type {string | null} */ why) => ({
    calibration: null,
    guidanceUrl: url,
    reason: why,
    estimate,
    camera: accept === "estimate" ? estimate : null,
  });
  if (!known) return missed(guidanceUrl, reason);
  const { adapted } = known;
  const data = adapted && !known.exact_size ? { ...known, ...adapted, exact_size: true } : known;
  if (exact && !data.exact_size) return missed(guidance(), "other_size");
  if (Math.max(data.uncertainty?.rms ?? 0, data.spread ?? 0) > maxError) return missed(guidance(), "too_uncertain");
  const calibration = new Calibration(data);
  return { calibration, guidanceUrl: null, reason: null, estimate: null, camera: calibration };
}

/** Storage of a tab; in memory in workers, and where a page may keep none. */
function tabs() {
  try {
    return globalThis.sessionStorage ?? worker;
  } catch (error) {
    if (error instanceof DOMException) return worker;
    throw error;
  }
}

/**
 * Calibration in the cache; null if its text is damaged: then it is requested again.
 * @param {Options["cache"]} cache
 * @param {string} name
 */
function remembered(cache, name) {
  try {
    const kept = JSON.parse(cache?.getItem(name) ?? "null");
    return kept?.camera_matrix ? kept : null;
  } catch (error) {
    if (error instanceof SyntaxError) return null;
    throw error;
  }
}

/** @param {Options["cache"]} cache @param {string} name @param {CalibrationData} calibration */
const keep = (cache, name, calibration) => store(cache, name, JSON.stringify(calibration));

/** @param {Options["cache"]} cache @param {string} name @param {string} value */
function store(cache, name, value) {
  try {
    cache?.setItem(name, value);
  } catch (error) {
    if (!(error instanceof DOMException)) throw error; // full: the next lookup asks the service again
  }
}
