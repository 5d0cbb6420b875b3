// One guided capture at the service. Views are kept here too: when the session expires, a new one is given them again.
import { ApiError } from "./api.js";

/**
 * @typedef {import("./stillness.js").Corners} Corners
 * @typedef {import("../vendor/api.js").Pose} Pose
 * @typedef {import("../vendor/api.js").SessionRequest} SessionRequest
 * @typedef {import("../vendor/api.js").SessionState} SessionState
 * @typedef {import("../vendor/api.js").ViewAnswer} ViewAnswer
 */

export class CaptureSession {
  #api;
  #token;
  #request;
  #credential = "";
  /** @type {Map<number, Corners>} accepted views by index */
  #views = new Map();
  /** The view that was sent last: its answer may be lost. @type {{index: number, corners: Corners} | null} */
  #sent = null;

  /** @param {import("./api.js").Api} api @param {string} token API token @param {SessionRequest} request */
  constructor(api, token, request) {
    this.#api = api;
    this.#token = token;
    this.#request = request;
  }

  /** @returns {Promise<SessionState>} */
  async start() {
    const { session_id } = await this.#api.json("POST", "/auth", this.#token);
    this.#credential = session_id;
    return this.#api.json("POST", "/session", session_id, { body: this.#request });
  }

  /**
   * Goes on after the camera or the network was lost: by another connection, with the views taken so far.
   * @param {import("./api.js").Api} api @returns {Promise<SessionState>}
   */
  resume(api) {
    this.#api = api;
    return this.#lasting(async () => {
      const state = /** @type {SessionState} */ (await this.#call("GET", "/session"));
      const sent = this.#sent;
      if (sent && state.views.some(({ index }) => index === sent.index)) this.#views.set(sent.index, sent.corners);
      return state;
    });
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
      const picture = await this.#api.send("GET", "/session/pose", this.#credential, { accept: "image/jpeg" });
      return { pose, picture: await picture.blob() };
    });
  }

  /** @param {number} index of the pose it answers @param {Corners} corners @returns {Promise<ViewAnswer>} */
  submit(index, corners) {
    return this.#lasting(async (restored) => {
      const open = restored ? (await this.#call("GET", "/session/pose")).index : index;
      return this.#submit(open, corners);
    });
  }

  /** Takes the last view back. @returns {Promise<SessionState>} */
  undo() {
    return this.#lasting(async () => {
      const index = [...this.#views.keys()].at(-1);
      if (index === undefined) throw new RangeError("there is no view to take back");
      const state = await this.#call("DELETE", `/session/views/${index}`);
      this.#views.delete(index);
      return state;
    });
  }

  /** @param {number} index @param {Corners} corners @returns {Promise<ViewAnswer>} */
  async #submit(index, { ids, points }) {
    this.#sent = { index, corners: { ids, points } };
    const answer = await this.#call("POST", "/session/views", { index, ids, points });
    if (answer.accepted) this.#views.set(index, { ids, points });
    return answer;
  }

  /** @param {string} method @param {string} path @param {object} [body] */
  #call(method, path, body) {
    return this.#api.json(method, path, this.#credential, { body });
  }

  /**
   * Does something that needs the session; once more in a new session when this one has expired.
   * @template T @param {(restored: boolean) => Promise<T>} action @returns {Promise<T>}
   */
  async #lasting(action) {
    try {
      return await action(false);
    } catch (error) {
      if (!(error instanceof ApiError) || error.status !== 401) throw error;
    }
    await this.#restore();
    return action(true);
  }

  async #restore() {
    const views = [...this.#views.values()];
    this.#views.clear();
    this.#sent = null;
    await this.start();
    for (const view of views) {
      const { index } = await this.#call("GET", "/session/pose");
      const { status } = await this.#submit(index, view);
      if (status === "converged") return;
    }
  }
}
