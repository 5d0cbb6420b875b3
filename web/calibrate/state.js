// The guided capture as a reducer: all that the page knows, and how each event changes it. No clock, no DOM, no network.
import { MOVING, motion, observe } from "./stillness.js";
import { foreshortening, observedOutline } from "./area.js";
import { jaccard } from "./jaccard.js";
import { difference } from "./target.js";
import { instruct, SILENT } from "./instruction.js";

/**
 * @typedef {Required<import("../vendor/api.js").Board>} Board
 * @typedef {import("../sdk/calibdb.js").CameraKey} CameraKey
 * @typedef {import("./camera.js").Choice} Choice
 * @typedef {import("./session.js").Pose} Pose
 * @typedef {import("./session.js").SessionState} SessionState
 * @typedef {import("./session.js").ViewAnswer} ViewAnswer
 * @typedef {import("./stillness.js").Corners} Corners
 * @typedef {import("./detector.js").Detection} Detection
 *
 * @typedef {object} Wanted the camera that the page was opened for
 * @property {string | null} camera
 * @property {[number, number] | null} img_size
 * @property {"rectilinear" | "fisheye"} distortion_model
 *
 * @typedef {object} State
 * @property {"welcome" | "opening" | "capturing" | "done" | "failed"} phase
 * @property {Board} board
 * @property {Wanted} wanted
 * @property {Choice[]} cameras
 * @property {CameraKey | null} key of the open camera
 * @property {boolean} mirrored
 * @property {boolean} cropped
 * @property {"camera" | "detector" | "service"} waiting what a capture that begins waits for
 * @property {number} loading 0…1, how much of OpenCV has arrived
 * @property {SessionState | null} session
 * @property {number} progress 0…1, never falls but by an undo
 * @property {Pose | null} pose
 * @property {[number, number][] | null} aim the board's outline in that pose, px; null where too little of it is in the picture
 * @property {string | null} picture address of the pose's overlay
 * @property {number} posedAt ms
 * @property {Corners} corners of the last frame
 * @property {number} markers seen in the last frame
 * @property {[number, number][] | null} outline of the board in the last frame, px
 * @property {number} overlap with the target, 0…1
 * @property {import("./stillness.js").Stillness} stillness
 * @property {Corners | null} answered the hold that was sent last: the same is not sent twice
 * @property {number | null} futile ms to wait since a view in the target's place was refused: it cannot be answered from there
 * @property {boolean} busy a view or a pose is on its way
 * @property {{text: string, kind: "good" | "bad" | "plain"} | null} notice what became of the last view
 * @property {number} noticedAt ms
 * @property {number} patience attempts to reach the service since it last answered
 * @property {import("./instruction.js").Instruction} instruction
 * @property {number | null} stopAsked ms, when a stop was asked for that would lose views
 * @property {string | null} failure
 *
 * @typedef {{type: "cameras", cameras: Choice[]}
 *   | {type: "open"}
 *   | {type: "waiting", waiting: State["waiting"]}
 *   | {type: "loading", fraction: number}
 *   | {type: "opened", key: CameraKey, mirrored: boolean, cropped: boolean}
 *   | {type: "session", session: SessionState}
 *   | {type: "pose", pose: Pose, picture: string, time: number}
 *   | {type: "frame", detection: Detection, time: number}
 *   | {type: "busy"}
 *   | {type: "idle"}
 *   | {type: "answer", answer: ViewAnswer, corners: Corners, time: number}
 *   | {type: "undone", session: SessionState, time: number}
 *   | {type: "patience", attempt: number}
 *   | {type: "stop", time: number}
 *   | {type: "failed", message: string}
 *   | {type: "restart"}} Event
 */

export const HOLD = 500; // ms still in the target's place
export const LONG_HOLD = 1500; // ms still anywhere else: the service judges whether it helps all the same
const OVERLAP = 0.6; // Jaccard index with the target that counts as there,
const DIFFERENCE = 0.08; // where the board also lies as the target does
const TILTED = 0.08; // foreshortening from which a pose other than the target may be worth sending
const FRAMES = 3; // in a hold at least: a video that delivers nothing new is not a steady hand
const NEW_PLACE = 8; // px at 1280 px image width from the hold that was sent last
const STUCK = 15_000; // ms without an accepted view, then another kind of pose is asked for
const FUTILE = 3_000; // ms after a refusal in the target's place: time to read why
const USELESS = 1_000; // ms after one that nothing can be done about
const NOTICE = 4_000; // ms a notice stays
const STOP = 5_000; // ms in which a stop must be asked for once more

/** What a refusal means to the person holding the board. @type {Record<string, string>} */
export const REFUSALS = {
  too_few_points: "Too little of the board was seen.",
  degenerate: "That view says too little. Tilt the board.",
  mirrored: "The picture is mirrored. Switch that off in the camera's settings.",
  outlier: "That view did not fit the others. Is the board flat?",
  no_information: "That view adds nothing new. Follow the outline.",
};

/** A device that was turned delivers another picture, of other intrinsics. */
export const RESIZED = "The picture's size changed. Hold the device as it was and try again, or go on with the new size: " +
  "that is a calibration of its own.";

/** @param {Board} board @param {Wanted} wanted @returns {State} */
export function initial(board, wanted) {
  return {
    phase: "welcome", board, wanted, cameras: [], key: null, mirrored: false, cropped: false, waiting: "camera", loading: 0,
    session: null, progress: 0, pose: null, aim: null, picture: null, posedAt: 0,
    corners: { ids: [], points: [] }, markers: 0, outline: null, overlap: 0, stillness: MOVING,
    answered: null, futile: null, busy: false, notice: null, noticedAt: 0, patience: 0, instruction: SILENT, stopAsked: null, failure: null,
  };
}

/** @param {State} state @param {Event} event @returns {State} */
export function reduce(state, event) {
  switch (event.type) {
    case "cameras":
      return { ...state, cameras: event.cameras };
    case "open":
      // The last session, if any, is named until the service answers: it may be taken up again.
      return { ...afresh(state), phase: "opening", session: state.session };
    case "waiting":
      return { ...state, waiting: event.waiting };
    case "loading":
      return { ...state, loading: event.fraction };
    case "opened":
      return { ...state, key: event.key, mirrored: event.mirrored, cropped: event.cropped };
    case "session":
      return inSession(state, event.session);
    case "pose":
      return {
        ...state, pose: event.pose, picture: event.picture, posedAt: event.time, futile: null, busy: false,
        aim: observedOutline(state.board, { ids: event.pose.ids, points: event.pose.corners }),
        overlap: overlap(state.outline, event.pose, state.key),
      };
    case "frame":
      return state.phase === "capturing" ? seen(state, event) : state;
    case "busy":
      return { ...state, busy: true };
    case "idle":
      return { ...state, busy: false };
    case "answer":
      return answered(state, event);
    case "undone":
      return {
        ...inSession(state, event.session), progress: event.session.progress, busy: false, answered: null,
        notice: { text: "The last view was taken back.", kind: "good" }, noticedAt: event.time,
      };
    case "patience":
      // What became of the last view is old by now, and would be read as the state of the connection.
      return { ...state, patience: event.attempt, notice: event.attempt > 0 ? null : state.notice };
    case "stop":
      return stopped(state, event.time);
    case "failed":
      return { ...state, phase: "failed", failure: event.message, busy: false, patience: 0 };
    case "restart":
      return afresh(state);
  }
}

/** All forgotten but what belongs to the page. @param {State} state @returns {State} */
function afresh({ board, wanted, cameras, loading }) {
  return { ...initial(board, wanted), cameras, loading };
}

/** Views are lost at the second press only. @param {State} state @param {number} time @returns {State} */
function stopped(state, time) {
  if (state.phase !== "capturing" || !state.session?.views.length || state.stopAsked !== null) return afresh(state);
  const notice = /** @type {const} */ ({ text: "Press once more to stop.", kind: "plain" });
  return { ...state, stopAsked: time, notice, noticedAt: time };
}

/** @param {State} state @param {SessionState} session @returns {State} */
function inSession(state, session) {
  const done = session.status === "converged";
  return {
    ...state,
    session,
    phase: done ? "done" : "capturing",
    progress: done ? 1 : Math.max(state.progress, session.progress),
    pose: done ? null : state.pose,
    picture: done ? null : state.picture,
  };
}

/** @param {State} state @param {{detection: Detection, time: number}} event @returns {State} */
function seen(state, { detection, time }) {
  const { ids, points, markers, size } = detection;
  if (!isOfSize(size, state.key)) return reduce(state, { type: "failed", message: RESIZED });
  const corners = { ids, points };
  const outline = observedOutline(state.board, corners);
  /** @type {State} */
  const next = {
    ...state,
    corners,
    markers,
    outline,
    overlap: overlap(outline, state.pose, state.key),
    stillness: observe(state.stillness, corners, time, size[0]),
    notice: time - state.noticedAt > NOTICE ? null : state.notice,
    stopAsked: state.stopAsked !== null && time - state.stopAsked > STOP ? null : state.stopAsked,
  };
  return { ...next, instruction: instruct(next, requiredHold(next) === HOLD, time) };
}

/** @param {State} state @param {{answer: ViewAnswer, corners: Corners, time: number}} event @returns {State} */
function answered(state, { answer, corners, time }) {
  // With no other view to contradict, it is the view by itself that no camera could be fitted to.
  const reason = answer.reason === "outlier" && answer.views.length === 0 ? "degenerate" : answer.reason;
  // Who has done what was asked is not told to do it.
  const useless = reason === "no_information" && isThere(state);
  /** @type {State["notice"]} */
  const notice = answer.accepted
    ? { text: `View ${answer.views.length} taken.`, kind: "good" }
    : useless ? { text: "Looking for a better pose.", kind: "plain" } : { text: REFUSALS[reason ?? ""] ?? "That view was not taken.", kind: "bad" };
  return {
    ...inSession(state, answer),
    answered: corners,
    futile: answer.accepted || !isThere(state) ? null : useless ? USELESS : FUTILE,
    busy: false,
    notice,
    noticedAt: time,
    // The answered target is gone at once; the next one is fetched. A refused one stays.
    ...(answer.accepted ? { pose: null, picture: null } : {}),
  };
}

/** @param {[number, number]} size of a frame, px @param {CameraKey | null} key */
export function isOfSize([width, height], key) {
  return width === key?.img_size[0] && height === key.img_size[1];
}

/** @param {[number, number][] | null} outline @param {Pose | null} pose @param {CameraKey | null} key */
function overlap(outline, pose, key) {
  return outline && pose && key ? jaccard(outline, pose.outline, key.img_size) : 0;
}

/** Is the board where the target is, and as it is? @param {State} state */
function isThere({ overlap: there, outline, aim }) {
  return there > OVERLAP && outline !== null && (aim === null || difference(outline, aim) < DIFFERENCE);
}

/**
 * How long the board must be held still where it is now; null: as long as one likes, it will not be taken.
 * @param {State} state
 */
export function requiredHold(state) {
  const { key, pose, outline, answered: sent, corners } = state;
  if (!key || !pose || !outline) return null;
  if (sent && motion(sent, corners) < (NEW_PLACE * key.img_size[0]) / 1280) return null;
  if (isThere(state)) return HOLD;
  return foreshortening(outline) > TILTED ? LONG_HOLD : null;
}

/** The hold as shown: 0…1. @param {State} state */
export function holdProgress(state) {
  const required = requiredHold(state);
  return required === null || state.busy ? 0 : Math.min(1, state.stillness.held / required);
}

/**
 * What the page should do by itself now.
 * @param {State} state @param {number} time ms
 * @returns {"submit" | "skip" | null}
 */
export function decide(state, time) {
  if (state.phase !== "capturing" || state.busy || !state.pose) return null;
  const required = requiredHold(state);
  if (required !== null && state.stillness.held >= required && state.stillness.frames >= FRAMES) return "submit";
  // Where no board is in sight, another pose would not help.
  if (state.corners.ids.length === 0) return null;
  const stuck = state.futile !== null ? time - state.noticedAt > state.futile : time - state.posedAt > STUCK;
  return stuck ? "skip" : null;
}
