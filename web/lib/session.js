// Session of one guided capture at the service. Its views are also stored in the page and on this device: nothing is
// lost when the session expires, the network fails or the page is reloaded.
import { ApiError, OfflineError } from "./api.js";
import { consentFields } from "./consent.js";
import { keepReceipt } from "./receipts.js";

/**
 * @import { Api } from "./api.js"
 * @import { Corners } from "./board-outline.js"
 */

/**
 * @typedef {import("../vendor/api.js").Pose} Pose
 * @typedef {import("../vendor/api.js").SessionRequest} SessionRequest
 * @typedef {import("../vendor/api.js").SessionState} SessionState
 * @typedef {import("../vendor/api.js").ViewAnswer} ViewAnswer
 *
 * @typedef {object} View
 * @property {number[]} ids
 * @property {number[][]} points px
 * @property {number | null} index of the pose that it was sent for; null: not yet sent
 * @property {boolean} taken the service has said that it is part of the session
 *
 * @typedef {object} SavedCapture all that is needed to resume a capture
 * @property {string} about key of the capture: camera, size, board, model
 * @property {string} camera its label
 * @property {string} credential
 * @property {View[]} views
 * @property {string} [address] of the page that it was captured with, "?virtual=1"
 *
 * @typedef {{credential?: string, body?: object, accept?: string}} RequestOptions credential: another than the
 *   session's own
 *
 * @typedef {object} Resumed outcome of sending the views that were waiting
 * @property {SessionState} state
 * @property {number} taken
 * @property {number} refused
 */

/** True if the service is unavailable for a while. @param {unknown} error */
export const isUnavailable = (error) => error instanceof OfflineError || (error instanceof ApiError && error.passing);

export class CaptureSession {
  #api;
  #token;
  #request;
  #about;
  #credential = "";
  /** Number of new sessions that replaced an expired one. */
  renewals = 0;
  /** @type {View[]} in the order in which they were captured */
  #views = [];
  #save;
  #answered;
  /** Called before each request. @type {(isFirst: boolean) => void} isFirst: none of its kind has been answered yet */
  onRequest = () => {};
  /** Called after each response. */
  onResponse = () => {};

  /**
   * @param {Api} api @param {string} token API token @param {SessionRequest} request
   * @param {{about?: string, save?: (capture: SavedCapture) => void, saved?: SavedCapture | null, answered?:
   *   Set<string>}} [memory] save: called after each change; saved: by an earlier page; answered: kinds of requests
   *   that have been answered before
   */
  constructor(api, token, request, { about = "", save = () => {}, saved = null, answered = new Set() } = {}) {
    this.#api = api;
    this.#token = token;
    this.#request = request;
    this.#about = about;
    this.#save = save;
    this.#answered = answered;
    if (saved) {
      this.#credential = saved.credential;
      this.#views = saved.views.map((view) => ({ ...view }));
    }
  }

  /** Views that the service does not have yet. */
  get waiting() {
    return this.#views.filter(({ taken }) => !taken).length;
  }

  /** Number of views that the service may lack. @param {{session: SessionState | null}} capture */
  stored({ session }) {
    return session ? this.waiting : this.size;
  }

  /** All views, wherever they are. */
  get size() {
    return this.#views.length;
  }

  /** True if the service has the last view: then only the service can undo it. */
  get lastIsTaken() {
    return this.#views.at(-1)?.taken ?? false;
  }

  /** Body of POST /v1/session. */
  get request() {
    return this.#request;
  }

  /** @returns {Promise<SessionState>} */
  async start() {
    const { session_id } = await this.#call("POST", "/auth", { credential: this.#token });
    const state = await this.#call("POST", "/session", {
      credential: session_id,
      body: { ...this.#request, ...consentFields() },
    });
    this.#credential = session_id;
    return state;
  }

  /** Facts about the camera, for sessions that are started from now on. @param {SessionRequest["track"]} track */
  track(track) {
    this.#request = { ...this.#request, track };
  }

  /**
   * The capture as if nothing of it had been sent.
   * @param {number[]} [without] indices of views to leave out
   * @returns {SavedCapture}
   */
  unsent(without = []) {
    const left = this.#views.filter(({ index }) => index === null || !without.includes(index));
    const views = left.map((view) => ({ ...view, index: null, taken: false }));
    return { about: this.#about, camera: this.#request.camera, credential: "", views };
  }

  /**
   * Resumes the capture after the camera, the network or the page was lost, with all views so far.
   * @param {Api} [api]
   * @param {{onSending?: () => void}} [options] onSending: called when the service is there and views are about to be
   *   sent
   * @returns {Promise<Resumed>}
   */
  async resume(api = this.#api, { onSending = () => {} } = {}) {
    this.#api = api;
    if (this.#credential === "") await this.start(); // it was opened while the service was away
    return this.#withSession(() => this.#reconcile(onSending));
  }

  /**
   * Fetches the next target, and the picture that shows it.
   * @param {{skip?: boolean}} [options] skip: a pose of another kind
   * @returns {Promise<{pose: Pose, picture: Blob}>}
   */
  pose({ skip = false } = {}) {
    return this.#withSession(async () => {
      const pose = await this.#call("GET", `/session/pose${skip ? "?skip=1" : ""}`);
      // The same pose until a view answers it, so the picture is of this one.
      const picture = await this.#fetch("GET", "/session/pose", { accept: "image/jpeg" });
      return { pose, picture: await picture.blob() };
    });
  }

  /**
   * Stores the view, and sends it. While the service is away the view stays here and `resume` sends it.
   * @param {number} index of the pose it answers @param {Corners} corners @returns {Promise<ViewAnswer>}
   */
  submit(index, corners) {
    const view = this.#add(corners);
    return this.#withSession(async (renewed) => {
      return this.#send(view, renewed ? (await this.#call("GET", "/session/pose")).index : index);
    }, view);
  }

  /** Stores a view until the service is back. @param {Corners} corners */
  store(corners) {
    this.#add(corners);
  }

  /** Undoes the last view. @returns {Promise<SessionState | null>} null: it had not been sent */
  undo() {
    return this.#withSession(async () => {
      const last = this.#views.at(-1);
      if (!last) throw new RangeError("there is no view to undo");
      const state = last.taken ? await this.#call("DELETE", `/session/views/${last.index}`) : null;
      this.#views = this.#views.filter((view) => view !== last); // others may have been stored meanwhile
      this.#persist();
      return state;
    });
  }

  /** Ends the capture with the views that the service has. @returns {Promise<SessionState>} */
  finish() {
    return this.#withSession(() => this.#call("POST", "/session/finish"));
  }

  /**
   * Publishes the measurements, as the person has agreed since. A session that has expired is not started again for it.
   * @param {Api} api that of the capture is cancelled with it
   */
  license(api) {
    return api.json("POST", "/session/licence", this.#credential, { body: consentFields() });
  }

  /** @param {Corners} corners */
  #add({ ids, points }) {
    const view = { ids, points, index: null, taken: false };
    this.#views.push(view);
    this.#persist();
    return view;
  }

  /** @param {View} view @param {number} index @returns {Promise<ViewAnswer>} */
  async #send(view, index) {
    view.index = index;
    this.#persist(); // if the response is lost, this records which view the service may have
    const answer = await this.#call("POST", "/session/views", { body: { index, ids: view.ids, points: view.points } });
    view.taken = answer.accepted;
    keepReceipt(this.#credential, answer);
    if (!view.taken) this.#views = this.#views.filter((each) => each !== view);
    this.#persist();
    return answer;
  }

  /** Sends the views that the service does not have. @param {() => void} onSending @returns {Promise<Resumed>} */
  async #reconcile(onSending) {
    let state = /** @type {SessionState} */ (await this.#call("GET", "/session"));
    const there = new Set(state.views.map(({ index }) => index));
    for (const view of this.#views) view.taken = view.index !== null && there.has(view.index);
    let [taken, refused] = [0, 0];
    if (this.waiting > 0 && state.status !== "converged") onSending();
    for (const view of this.#views.filter((each) => !each.taken)) {
      if (state.status === "converged") break;
      const answer = await this.#send(view, (await this.#call("GET", "/session/pose")).index);
      if (answer.accepted) taken += 1;
      else refused += 1;
      state = answer;
    }
    this.#persist();
    return { state, taken, refused };
  }

  #persist() {
    const views = this.#views.map((view) => ({ ...view }));
    this.#save({ about: this.#about, camera: this.#request.camera, credential: this.#credential, views });
  }

  /** @param {string} method @param {string} path @param {RequestOptions} [options] @returns {Promise<any>} the body */
  async #call(method, path, options) {
    const answer = await this.#fetch(method, path, options);
    return answer.status === 204 ? null : answer.json();
  }

  /** @param {string} method @param {string} path @param {RequestOptions} [options] */
  async #fetch(method, path, { credential = this.#credential, ...options } = {}) {
    const kind = `${method} ${path.replace(/[?\d].*/, "")}`;
    this.onRequest(!this.#answered.has(kind));
    const answer = await this.#api.send(method, path, credential, { ...options, brief: true });
    this.#answered.add(kind);
    this.onResponse();
    return answer;
  }

  /**
   * Runs an action that needs the session; once more in a new session if this one has expired.
   * @template T @param {(renewed: boolean) => Promise<T>} action @param {View | null} [own] the view that the action
   *   itself sends @returns {Promise<T>}
   */
  async #withSession(action, own = null) {
    try {
      return await action(false);
    } catch (error) {
      if (!isExpired(error)) throw error;
    }
    for (const view of this.#views) [view.index, view.taken] = [null, false];
    await this.start();
    this.renewals += 1;
    this.#persist();
    for (const view of this.#views.filter((each) => each !== own)) {
      const { index } = await this.#call("GET", "/session/pose");
      if ((await this.#send(view, index)).status === "converged") break;
    }
    return action(true);
  }
}

/** True if the session has expired or was forgotten. @param {unknown} error */
function isExpired(error) {
  return (
    error instanceof ApiError && (error.status === 401 || error.kind === "session-expired" || error.status === 404)
  );
}
