// Rig at the service: its HTTP calls. Each may be repeated: the service answers the same again.

/** @import { RigOpened as Created, SessionState } from "../vendor/api.js" */

/**
 * @typedef {import("../vendor/api.js").SessionRequest} SessionRequest
 * @typedef {import("../vendor/api.js").RigState & {board: import("../lib/board.js").SentBoard}} RigState
 * @typedef {import("../vendor/api.js").RigResult} RigResult
 * @typedef {import("../vendor/api.js").RigTargetView} Target
 * @typedef {import("../vendor/api.js").RigMoment} Moment
 * @typedef {import("../vendor/api.js").Extrinsics} Extrinsic
 * @typedef {import("../sdk/calibration.js").CalibrationData} CalibrationData
 *
 * @typedef {{moment: string, ids: number[], points: number[][]}} RigView one camera's view of a moment; points: px
 *
 * @typedef {{state: RigState, etag: string}} Answer
 */

export class RigService {
  #api;
  #token;

  /** @param {Pick<import("../lib/api.js").Api, "send" | "json">} api @param {string} token of the pages */
  constructor(api, token) {
    this.#api = api;
    this.#token = token;
  }

  /** A session id: one camera's credential. @returns {Promise<string>} */
  async authenticate() {
    return (await this.#api.json("POST", "/auth", this.#token, { brief: true })).session_id;
  }

  /**
   * Opens one camera's session.
   * @param {string} session
   * @param {SessionRequest} request
   * @returns {Promise<SessionState>}
   */
  openSession(session, request) {
    return this.#api.json("POST", "/session", session, { body: request, brief: true });
  }

  /**
   * Makes the rig of the first camera's session, or a fresh code for it.
   * @param {string} session
   * @param {{cameras: number, square_size?: number}} rig
   * @returns {Promise<Created>}
   */
  create(session, rig) {
    return this.#api.json("POST", "/rigs", session, { body: rig, brief: true });
  }

  /**
   * @param {string} id
   * @param {string} [credential] of a member; the pages' token by default
   * @param {string} [etag] of the last answer
   * @returns {Promise<Answer | null>} null: nothing has changed
   */
  async state(id, credential = this.#token, etag = "") {
    const answer = await this.#api.send("GET", path(id), credential, { brief: true, etag });
    return answer.status === 304 ? null : { state: await answer.json(), etag: answer.headers.get("etag") ?? "" };
  }

  /** Asks for another target. @param {string} id @param {string} leader @returns {Promise<RigState>} */
  skip(id, leader) {
    return this.#api.json("GET", `${path(id)}?skip=1`, leader, { brief: true });
  }

  /** @param {string} id @param {string} leader @param {string} moment @returns {Promise<RigState>} */
  openMoment(id, leader, moment) {
    return this.#api.json("POST", `${path(id)}/moments`, leader, { body: { moment }, brief: true });
  }

  /**
   * Withdraws a moment in all cameras.
   * @param {string} id
   * @param {string} leader
   * @param {string} moment
   * @returns {Promise<RigState>}
   */
  undo(id, leader, moment) {
    return this.#api.json("DELETE", `${path(id)}/moments/${encodeURIComponent(moment)}`, leader, { brief: true });
  }

  /** @param {string} session @param {RigView} view @returns {Promise<{accepted: boolean, reason?: string | null}>} */
  submit(session, view) {
    return this.#api.json("POST", "/session/views", session, { body: view, brief: true });
  }

  /** @param {string} id @param {string} leader @returns {Promise<RigState>} */
  finish(id, leader) {
    return this.#api.json("POST", `${path(id)}/finish`, leader);
  }

  /** Forgets a rig that is not finished. @param {string} id @param {string} leader */
  async forget(id, leader) {
    await this.#api.send("DELETE", path(id), leader, { brief: true });
  }

  /** Gives up one camera's place in a rig that is not finished. @param {string} session */
  async leave(session) {
    await this.#api.send("DELETE", "/session", session, { brief: true });
  }

  /**
   * The result as a file.
   * @param {string} id
   * @param {string} format "" for the JSON that the SDK reads
   * @returns {Promise<Response>}
   */
  file(id, format) {
    const query = format ? `?${new URLSearchParams({ format })}` : "";
    return this.#api.send("GET", `${path(id)}/result${query}`, this.#token, { accept: "*/*" });
  }
}

/** @param {string} id */
const path = (id) => `/rigs/${encodeURIComponent(id)}`;
