// Rig at the service: its HTTP calls. Each may be repeated: the service answers the same again.

/**
 * @typedef {import("../lib/pose.js").Pose} Pose
 * @typedef {import("../lib/board.js").SentBoard} Board
 * @typedef {import("../vendor/api.js").SessionRequest} SessionRequest
 * @typedef {import("../vendor/api.js").SessionState} SessionState
 *
 * @typedef {{rig_id: string, join_code: string, expires_at: number}} Created expires_at: of the code, unix seconds
 *
 * @typedef {object} Member
 * @property {number} position
 * @property {string | null} camera label
 * @property {[number, number] | null} img_size px
 * @property {"waiting" | "capturing" | "finished"} status
 * @property {number} views
 *
 * @typedef {Pose & {position: number, ids: number[], corners: number[][], outline: [number, number][]}} Target of one
 *   camera; board → camera, px
 * @typedef {{position: number, reason: string, detail: string}} SetAside
 * @typedef {{id: string, positions: number[], set_aside?: SetAside[]}} Moment positions: cameras whose views it has
 * @typedef {{code: string, text: string, positions?: number[]}} Advice
 * @typedef {{rotation_deg: number, translation_percent: number, rms: number}} Uncertainty
 * @typedef {Pose & {position: number, std: number[]}} Extrinsic camera 0 → camera; std: of rvec and tvec
 * @typedef {import("../sdk/calibration.js").CalibrationData} CalibrationData
 *
 * @typedef {object} RigResult
 * @property {string[]} cameras ids of calibrations, by position
 * @property {CalibrationData[]} calibrations fitted jointly, by position
 * @property {Extrinsic[]} extrinsics by position; the first is 0
 * @property {"squares" | "metres"} unit
 * @property {number} rms px
 * @property {number | null} held_out_rms px
 * @property {Uncertainty | null} uncertainty
 * @property {{level: "good" | "fair" | "poor", reasons?: string[]} | string | null} verdict
 * @property {(Pose & {moment: string})[]} [board_poses] board → camera 0
 * @property {import("../lib/result/numbers.js").BoardShape} [board_shape] missing: as drawn
 *
 * @typedef {object} RigState
 * @property {string} rig_id
 * @property {"capturing" | "finished"} status
 * @property {Board} board
 * @property {number | null} square_size metres
 * @property {"squares" | "metres"} unit
 * @property {Member[]} cameras
 * @property {Moment | null} moment the one opened last
 * @property {Moment[]} moments
 * @property {Uncertainty | null} uncertainty
 * @property {number} target_error px
 * @property {number} progress 0…1
 * @property {number[]} unlinked positions
 * @property {number | null} rms px
 * @property {{purpose: string, hint?: unknown, cameras: Target[]} | null} target
 * @property {Advice[]} advice
 * @property {RigResult | null} result
 *
 * @typedef {object} RigView one camera's view of a moment
 * @property {string} moment
 * @property {number[]} ids
 * @property {number[][]} points px
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
