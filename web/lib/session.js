// One guided capture at the service. Its views are kept here too, and on this device: when the session expires, the
// network fails or the page is loaded anew, nothing that was captured is lost.
import { ApiError, OfflineError } from "./api.js";

/**
 * @typedef {import("./board-outline.js").Corners} Corners
 * @typedef {import("../vendor/api.js").Pose & {hint_code?: string}} Pose
 * @typedef {import("../vendor/api.js").SessionRequest} SessionRequest
 *
 * @typedef {object} ViewState
 * @property {number} index
 * @property {number} points
 * @property {number | null} rms
 * @property {{reason: string, detail: string} | null} [set_aside] why the view is not used any more
 *
 * @typedef {Omit<import("../vendor/api.js").SessionState, "views"> & {views: ViewState[], advice?: {code: string, text: string}[],
 *   suggested_model?: string | null}} SessionState
 * @typedef {SessionState & {accepted: boolean, reason: string | null, hint?: {code: string, text: string} | null}} ViewAnswer
 *
 * @typedef {object} View
 * @property {number[]} ids
 * @property {number[][]} points px
 * @property {number | null} index of the pose that it was sent for; null: not yet sent
 * @property {boolean} taken has the service said that it is part of the session?
 *
 * @typedef {object} Kept all that is needed to go on
 * @property {string} about what the capture is of: camera, size, board, model
 * @property {string} camera its label
 * @property {string} credential
 * @property {View[]} views
 * @property {string} [address] of the page that it was captured with, "?virtual=1"
 *
 * @typedef {{credential?: string, body?: object, accept?: string}} Asking credential: another than the session's own
 *
 * @typedef {object} Reconciled what became of the views that were waiting
 * @property {SessionState} state
 * @property {number} taken
 * @property {number} refused
 */

/** @param {unknown} error Is the service away, for a while? */
export const isAway = (error) => error instanceof OfflineError || (error instanceof ApiError && error.passing);

const ENOUGH = 8; // views in all, of which a fit is good where their poses were not chosen for it,
const MORE = 3; // and so many at least where the service went on asking

/** Views to keep while the service is away. @param {{session: SessionState | null}} capture */
export const wantedAway = ({ session }) => Math.max(MORE, ENOUGH - viewCount({ session, stored: 0 }));

/** Are there enough views to wait for the service with? @param {{away: boolean, session: SessionState | null, stored: number}} capture */
export const isEnough = (capture) => capture.away && capture.stored >= wantedAway(capture);

/** Views that the person has taken, wherever they are. @param {{session: SessionState | null, stored: number}} capture */
export const viewCount = ({ session, stored }) => (session?.views.filter(({ set_aside }) => !set_aside).length ?? 0) + stored;

export class CaptureSession {
  #api;
  #token;
  #request;
  #about;
  #credential = "";
  /** How often it was begun anew, with its views, since the one before was there no more. */
  restored = 0;
  /** @type {View[]} in the order in which they were captured */
  #views = [];
  #save;
  #known;
  /** Called whenever something is asked. @type {(isFirst: boolean) => void} isFirst: nothing of its kind was answered yet */
  onAsk = () => {};
  /** Called whenever the service has answered. */
  onAnswer = () => {};

  /**
   * @param {import("./api.js").Api} api @param {string} token API token @param {SessionRequest} request
   * @param {{about?: string, save?: (kept: Kept) => void, kept?: Kept | null, known?: Set<string>}} [memory] save: called
   *   whenever there is something new to keep; kept: of an earlier page; known: kinds of calls that were answered before
   */
  constructor(api, token, request, { about = "", save = () => {}, kept = null, known = new Set() } = {}) {
    this.#api = api;
    this.#token = token;
    this.#request = request;
    this.#about = about;
    this.#save = save;
    this.#known = known;
    if (kept) {
      this.#credential = kept.credential;
      this.#views = kept.views.map((view) => ({ ...view }));
    }
  }

  /** Views that the service does not have yet. */
  get waiting() {
    return this.#views.filter(({ taken }) => !taken).length;
  }

  /** How many views the service is not known to have. @param {{session: SessionState | null}} capture */
  stored({ session }) {
    return session ? this.waiting : this.size;
  }

  /** All views, wherever they are. */
  get size() {
    return this.#views.length;
  }

  /** Has the service the last view? Then it alone can take it back. */
  get lastIsTaken() {
    return this.#views.at(-1)?.taken ?? false;
  }

  /** What the session is about, as it is sent. */
  get request() {
    return this.#request;
  }

  /** @returns {Promise<SessionState>} */
  async start() {
    const { session_id } = await this.#call("POST", "/auth", { credential: this.#token });
    const state = await this.#call("POST", "/session", { credential: session_id, body: this.#request });
    this.#credential = session_id;
    return state;
  }

  /** The camera has changed its ways: a session that is begun from now on says so. @param {SessionRequest["track"]} track */
  track(track) {
    this.#request = { ...this.#request, track };
  }

  /** What is kept, as if nothing of it had ever been sent. @param {number[]} [without] indices of views that are not @returns {Kept} */
  unsent(without = []) {
    const kept = this.#views.filter(({ index }) => index === null || !without.includes(index));
    const views = kept.map((view) => ({ ...view, index: null, taken: false }));
    return { about: this.#about, camera: this.#request.camera, credential: "", views };
  }

  /**
   * Goes on after the camera, the network or the page was lost: by another connection, with all views so far.
   * @param {import("./api.js").Api} [api] @param {{onSending?: () => void}} [options] onSending: the service is there, and has views to come
   * @returns {Promise<Reconciled>}
   */
  async resume(api = this.#api, { onSending = () => {} } = {}) {
    this.#api = api;
    if (this.#credential === "") await this.start(); // it was begun while the service was away
    return this.#lasting(() => this.#reconcile(onSending));
  }

  /**
   * Where to hold the board, and the picture that shows it.
   * @param {{skip?: boolean}} [options] skip: a pose of another kind
   * @returns {Promise<{pose: Pose, picture: Blob}>}
   */
  pose({ skip = false } = {}) {
    return this.#lasting(async () => {
      const pose = await this.#call("GET", `/session/pose${skip ? "?skip=1" : ""}`);
      // The same pose until a view answers it, so the picture is of this one.
      const picture = await this.#ask("GET", "/session/pose", { accept: "image/jpeg" });
      return { pose, picture: await picture.blob() };
    });
  }

  /**
   * Keeps the view, and sends it. Where the service is away the view stays here and `resume` sends it.
   * @param {number} index of the pose it answers @param {Corners} corners @returns {Promise<ViewAnswer>}
   */
  submit(index, corners) {
    const view = this.#keep(corners);
    return this.#lasting(async (restored) => {
      return this.#send(view, restored ? (await this.#call("GET", "/session/pose")).index : index);
    }, view);
  }

  /** Keeps a view for when the service is there again. @param {Corners} corners */
  keep(corners) {
    this.#keep(corners);
  }

  /** Takes the last view back. @returns {Promise<SessionState | null>} null: it had not been sent */
  undo() {
    return this.#lasting(async () => {
      const last = this.#views.at(-1);
      if (!last) throw new RangeError("there is no view to take back");
      const state = last.taken ? await this.#call("DELETE", `/session/views/${last.index}`) : null;
      this.#views = this.#views.filter((view) => view !== last); // others may have been kept meanwhile
      this.#changed();
      return state;
    });
  }

  /** @param {Corners} corners */
  #keep({ ids, points }) {
    const view = { ids, points, index: null, taken: false };
    this.#views.push(view);
    this.#changed();
    return view;
  }

  /** @param {View} view @param {number} index @returns {Promise<ViewAnswer>} */
  async #send(view, index) {
    view.index = index;
    this.#changed(); // where the answer is lost, this tells which view the service may have
    const answer = await this.#call("POST", "/session/views", { body: { index, ids: view.ids, points: view.points } });
    view.taken = answer.accepted;
    if (!view.taken) this.#views = this.#views.filter((each) => each !== view);
    this.#changed();
    return answer;
  }

  /** Makes the service's views and ours the same. @param {() => void} onSending @returns {Promise<Reconciled>} */
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
    this.#changed();
    return { state, taken, refused };
  }

  #changed() {
    const views = this.#views.map((view) => ({ ...view }));
    this.#save({ about: this.#about, camera: this.#request.camera, credential: this.#credential, views });
  }

  /** @param {string} method @param {string} path @param {Asking} [asking] @returns {Promise<any>} the body */
  async #call(method, path, asking) {
    const answer = await this.#ask(method, path, asking);
    return answer.status === 204 ? null : answer.json();
  }

  /** @param {string} method @param {string} path @param {Asking} [asking] */
  async #ask(method, path, { credential = this.#credential, ...asking } = {}) {
    const kind = `${method} ${path.replace(/[?\d].*/, "")}`;
    this.onAsk(!this.#known.has(kind));
    const answer = await this.#api.send(method, path, credential, { ...asking, brief: true });
    this.#known.add(kind);
    this.onAnswer();
    return answer;
  }

  /**
   * Does something that needs the session; once more in a new session when this one is there no more.
   * @template T @param {(restored: boolean) => Promise<T>} action @param {View | null} [own] the view that the action
   *   itself sends @returns {Promise<T>}
   */
  async #lasting(action, own = null) {
    try {
      return await action(false);
    } catch (error) {
      if (!isGone(error)) throw error;
    }
    for (const view of this.#views) [view.index, view.taken] = [null, false];
    await this.start();
    this.restored += 1;
    this.#changed();
    for (const view of this.#views.filter((each) => each !== own)) {
      const { index } = await this.#call("GET", "/session/pose");
      if ((await this.#send(view, index)).status === "converged") break;
    }
    return action(true);
  }
}

/** Has the session expired, or been forgotten? @param {unknown} error */
function isGone(error) {
  return error instanceof ApiError && (error.status === 401 || error.kind === "session-expired" || error.status === 404);
}
