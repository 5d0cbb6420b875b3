// The guided capture as a reducer: all that the page knows, and how each event changes it. No clock, no DOM, no network.
import { MOVING, motion, observe } from "./stillness.js";
import { observedOutline } from "../lib/board-outline.js";
import { HEALTHY, diagnose } from "./diagnosis.js";
import { HOLD, isThere, lenience, requiredHold, timeToRead } from "./hold.js";
import { jaccard } from "./jaccard.js";
import { difference } from "./target.js";
import { HINTS, SILENT, asMirrored, instruct } from "./instruction.js";
import { viewCount, wantedAway } from "../lib/session.js";

/**
 * @typedef {Required<import("../vendor/api.js").Board>} Board
 * @typedef {import("../sdk/calibdb.js").CameraKey} CameraKey
 * @typedef {import("../lib/camera.js").Choice} Choice
 * @typedef {import("../lib/session.js").Pose} Pose
 * @typedef {import("../lib/session.js").SessionState} SessionState
 * @typedef {import("../lib/session.js").ViewAnswer} ViewAnswer
 * @typedef {import("./stillness.js").Corners} Corners
 * @typedef {import("../lib/detector.js").Detection} Detection
 *
 * @typedef {object} Wanted the camera that the page was opened for
 * @property {string | null} camera
 * @property {[number, number] | null} img_size
 * @property {"rectilinear" | "fisheye" | "rational" | "omnidirectional"} distortion_model
 *
 * @typedef {{key: string, kind: "good" | "bad" | "plain", values?: Record<string, string | number>, hint?: string}} Notice key: of a text;
 *   hint: the instruction that would help
 *
 * @typedef {object} State
 * @property {"welcome" | "opening" | "capturing" | "done" | "failed"} phase
 * @property {Board} board
 * @property {Wanted} wanted
 * @property {Choice[]} cameras
 * @property {{camera: string, views: number, about: string, address: string} | null} interrupted a capture that an earlier page left on this device
 * @property {CameraKey | null} key of the open camera
 * @property {import("../lib/session.js").SessionRequest | null} request what is sent about it
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
 * @property {{time: number, distance: number}} nearest to the target so far, and when
 * @property {Corners} corners of the last frame
 * @property {number} markers seen in the last frame
 * @property {[number, number][] | null} outline of the board in the last frame, px
 * @property {number} overlap with the target, 0…1
 * @property {import("./stillness.js").Stillness} stillness
 * @property {import("./diagnosis.js").Diagnosis} diagnosis
 * @property {Corners | null} answered the hold that was sent last: the same is not sent twice
 * @property {number | null} futile ms to wait since a view in the target's place was refused: it cannot be answered from there
 * @property {boolean} busy a view or a pose is on its way
 * @property {Notice | null} notice what became of the last view
 * @property {number} noticedAt ms
 * @property {number} patience attempts to reach the service since it last answered
 * @property {boolean} away the service cannot be reached: targets come from the page's own plan
 * @property {number} stored views that wait for it
 * @property {boolean} sending it is back, and is sent them
 * @property {boolean} stalled the detector has stopped, and is started again
 * @property {boolean} plain this device is too slow to colour the picture
 * @property {number} begunWith views that there were when the capture was begun, or taken up again
 * @property {boolean} kept is what was captured kept on this device?
 * @property {import("./instruction.js").Instruction} instruction
 * @property {number | null} stopAsked ms, when a stop was asked for that would lose views
 * @property {{code: string, detail: string} | null} failure a text `capture.fault_<code>`
 *
 * @typedef {{type: "cameras", cameras: Choice[]}
 *   | {type: "interrupted", interrupted: State["interrupted"]}
 *   | {type: "open"}
 *   | {type: "board", board: Board}
 *   | {type: "waiting", waiting: State["waiting"]}
 *   | {type: "loading", fraction: number}
 *   | {type: "opened", key: CameraKey, request?: State["request"], mirrored: boolean, cropped: boolean}
 *   | {type: "session", session: SessionState, stored?: number}
 *   | {type: "request", request: State["request"]}
 *   | {type: "model", model: Wanted["distortion_model"]}
 *   | {type: "offline", stored: number}
 *   | {type: "pose", pose: Pose, picture: string | null, time: number}
 *   | {type: "frame", detection: Detection, time: number}
 *   | {type: "busy"}
 *   | {type: "idle"}
 *   | {type: "sent", corners: Corners}
 *   | {type: "answer", answer: ViewAnswer, corners: Corners, time: number}
 *   | {type: "stored", corners: Corners, stored: number, time: number}
 *   | {type: "undone", session: SessionState | null, stored: number, time: number}
 *   | {type: "patience", attempt: number}
 *   | {type: "away", stored: number}
 *   | {type: "sending", sending: boolean}
 *   | {type: "back", session: SessionState, taken: number, refused: number, time: number}
 *   | {type: "stalled", stalled: boolean}
 *   | {type: "shown", time: number}
 *   | {type: "unkept"}
 *   | {type: "slow"}
 *   | {type: "told", notice: Notice, time: number}
 *   | {type: "stop", time: number}
 *   | {type: "failed", code: string, detail?: string}
 *   | {type: "restart"}} Event
 */

const NOTICE = 4_000; // ms a notice stays
const STOP = 5_000; // ms in which a stop must be asked for once more
const UNSURE = 0.95; // of the way at most, until the service has said that it is there
const NEARER = 0.05; // of the distance to the target that counts as coming nearer
/** What the service refuses views for, as far as the page has words for it. */
const REFUSALS = new Set(["too_few_points", "degenerate", "mirrored", "outlier", "no_information"]);

/** @param {Board} board @param {Wanted} wanted @returns {State} */
export function initial(board, wanted) {
  return {
    phase: "welcome", board, wanted, cameras: [], interrupted: null, key: null, request: null, mirrored: false, cropped: false,
    waiting: "camera", loading: 0, session: null, progress: 0, pose: null, aim: null, picture: null, posedAt: 0,
    nearest: { time: 0, distance: Infinity }, corners: { ids: [], points: [] }, markers: 0, outline: null, overlap: 0,
    stillness: MOVING, diagnosis: HEALTHY, answered: null, futile: null, busy: false, notice: null, noticedAt: 0, patience: 0,
    away: false, stored: 0, sending: false, stalled: false, plain: false, begunWith: 0, kept: true, instruction: SILENT, stopAsked: null, failure: null,
  };
}

/** @param {State} state @param {Event} event @returns {State} */
export function reduce(state, event) {
  switch (event.type) {
    case "cameras":
      return { ...state, cameras: event.cameras };
    case "interrupted":
      return { ...state, interrupted: event.interrupted };
    case "open":
      // The last session, if any, is named until the service answers: it may be taken up again.
      return { ...afresh(state), phase: "opening", session: state.session, stored: state.stored };
    case "board":
      return { ...state, board: event.board };
    case "waiting":
      return { ...state, waiting: event.waiting };
    case "loading":
      return { ...state, loading: event.fraction };
    case "opened":
      return { ...state, key: event.key, request: event.request ?? null, mirrored: event.mirrored, cropped: event.cropped };
    case "request":
      return { ...state, request: event.request };
    case "model":
      return { ...state, wanted: { ...state.wanted, distortion_model: event.model } };
    case "offline":
      return {
        ...state, phase: "capturing", session: null, away: true, stored: event.stored, begunWith: event.stored, patience: 0,
        progress: UNSURE * Math.min(1, event.stored / wantedAway({ session: null })),
      };
    case "session":
      return begun(state, { ...inSession(state, event.session), stored: event.stored ?? 0 });
    case "pose":
      return posed(state, event);
    case "frame":
      return state.phase === "capturing" ? seen(state, event) : state;
    case "busy":
      return { ...state, busy: true };
    case "idle":
      return { ...state, busy: false };
    case "sent":
      return { ...state, answered: event.corners };
    case "answer":
      return answered(state, event);
    case "stored":
      return notify(
        { ...state, answered: event.corners, stored: event.stored, progress: further(state), pose: null, picture: null, busy: false },
        { key: "capture.view_stored", kind: "good" }, event.time);
    case "undone":
      return undone(state, event);
    case "patience":
      // What became of the last view is old by now, and would be read as the state of the connection.
      return { ...state, patience: event.attempt, notice: event.attempt > 0 ? null : state.notice };
    case "away":
      // What stands while it is away says so: a notice beside it would say it twice.
      return { ...state, away: true, stored: event.stored, patience: 0, pose: null, picture: null, busy: false, notice: null };
    case "sending":
      return { ...state, sending: event.sending };
    case "back":
      return notify(
        { ...inSession(state, event.session), away: false, sending: false, stored: 0, patience: 0, pose: null, picture: null },
        returned(event), event.time);
    case "stalled":
      return { ...state, stalled: event.stalled };
    case "shown":
      // The time that nobody saw does not count.
      return { ...state, posedAt: event.time, nearest: { ...state.nearest, time: event.time }, stillness: MOVING, diagnosis: HEALTHY };
    case "unkept":
      return { ...state, kept: false };
    case "slow":
      return { ...state, plain: true };
    case "told":
      return notify(state, event.notice, event.time);
    case "stop":
      return stopped(state, event.time);
    case "failed":
      return { ...state, phase: "failed", failure: { code: event.code, detail: event.detail ?? "" }, busy: false, patience: 0 };
    case "restart":
      return afresh(state);
  }
}

/** All forgotten but what belongs to the page. @param {State} state @returns {State} */
function afresh({ board, wanted, cameras, loading, interrupted, plain }) {
  return { ...initial(board, wanted), cameras, loading, interrupted, plain };
}

/** @param {State} state @param {Notice} notice @param {number} time @returns {State} */
const notify = (state, notice, time) => ({ ...state, notice, noticedAt: time });

/** One more view that is kept brings it that much nearer to its end, as far as can be told without the service. @param {State} state */
const further = (state) => state.progress + Math.max(0, UNSURE - state.progress) / Math.max(1, wantedAway(state) - state.stored);

/** What became of the views that were kept. @param {{taken: number, refused: number}} event @returns {Notice} */
function returned({ taken, refused }) {
  if (refused) return { key: "capture.came_back_less", kind: "good", values: { count: refused } };
  return { key: taken ? "capture.came_back" : "capture.came_back_only", kind: "good" };
}

/** Views are lost at the second press only. @param {State} state @param {number} time @returns {State} */
function stopped(state, time) {
  if (state.phase !== "capturing" || viewCount(state) === 0 || state.stopAsked !== null) return afresh(state);
  return notify({ ...state, stopAsked: time }, { key: "capture.press_again", kind: "plain", values: { count: viewCount(state) } }, time);
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

/** @param {State} before @param {State} state @returns {State} */
const begun = (before, state) => (before.phase === "capturing" ? state : { ...state, begunWith: viewCount(state) });

/** @param {State} state @param {{pose: Pose, picture: string | null, time: number}} event @returns {State} */
function posed(state, { pose, picture, time }) {
  /** @type {State} */
  const next = {
    ...state, pose, picture, posedAt: time, futile: null, busy: false,
    nearest: { time, distance: Infinity },
    aim: observedOutline(state.board, { ids: pose.ids, points: pose.corners }),
    overlap: overlap(state.outline, pose, state.key),
  };
  // What was said was about another target: nobody should go on holding still for it.
  if (!state.outline) return next;
  return { ...next, instruction: instruct({ ...next, instruction: SILENT }, requiredHold(next) === HOLD, time) };
}

/** @param {State} state @param {{detection: Detection, time: number}} event @returns {State} */
function seen(state, { detection, time }) {
  const { ids, points, markers, size } = detection;
  if (!isOfSize(size, state.key)) return reduce(state, { type: "failed", code: "resized" });
  const found = { ids, points };
  const moved = motion(state.corners, found);
  const stillness = observe(state.stillness, found, time, size[0], lenience(state, time));
  // A frame that is smeared in the middle of a hold is passed over, or the ring would start again and again.
  const passed = stillness === state.stillness;
  const corners = passed ? state.corners : found;
  const outline = passed ? state.outline : observedOutline(state.board, corners);
  /** @type {State} */
  const next = {
    ...state,
    corners,
    markers: passed ? state.markers : markers,
    outline,
    overlap: overlap(outline, state.pose, state.key),
    stillness,
    diagnosis: diagnose(state.diagnosis, detection, moved, time),
    notice: time - state.noticedAt > NOTICE ? null : state.notice,
    stopAsked: state.stopAsked !== null && time - state.stopAsked > STOP ? null : state.stopAsked,
  };
  const distance = next.outline && next.aim ? 1 - next.overlap + difference(next.outline, next.aim) : Infinity;
  const nearest = distance < state.nearest.distance - NEARER ? { time, distance } : state.nearest;
  return { ...next, nearest, instruction: instruct(next, requiredHold(next) === HOLD, time) };
}

/** @param {State} state @param {{answer: ViewAnswer, corners: Corners, time: number}} event @returns {State} */
function answered(state, { answer, corners, time }) {
  // With no other view to contradict, it is the view by itself that no camera could be fitted to.
  const reason = answer.reason === "outlier" && answer.views.length === 0 ? "degenerate" : answer.reason;
  // Who has done what was asked is not told to do it.
  const useless = reason === "no_information" && isThere(state);
  return {
    ...inSession(state, answer),
    answered: corners,
    futile: answer.accepted || !isThere(state) ? null : timeToRead(useless),
    busy: false,
    notice: verdict(state, answer, useless ? "useless" : reason),
    noticedAt: time,
    // The answered target is gone at once; the next one is fetched. A refused one stays.
    ...(answer.accepted ? { pose: null, picture: null } : {}),
  };
}

/** @param {State} state @param {ViewAnswer} answer @param {string | null} reason @returns {Notice} */
function verdict(state, answer, reason) {
  if (!answer.accepted) {
    if (reason === "useless") return { key: "capture.useless", kind: "plain" };
    const key = REFUSALS.has(reason ?? "") ? `capture.refused_${reason}` : "capture.refused";
    const hint = answer.hint && HINTS.has(answer.hint.code) ? answer.hint.code : undefined;
    return { key, kind: "bad", ...(hint && { hint: state.mirrored ? asMirrored(hint) : hint }) };
  }
  const before = new Set(state.session?.views.filter(({ set_aside }) => set_aside).map(({ index }) => index));
  const aside = answer.views.find(({ index, set_aside }) => set_aside && !before.has(index));
  if (aside) return { key: "capture.view_set_aside", kind: "plain", values: { number: answer.views.indexOf(aside) + 1 } };
  return { key: "capture.view_taken", kind: "good", values: { number: answer.views.length } };
}

/** @param {State} state @param {{session: SessionState | null, stored: number, time: number}} event @returns {State} */
function undone(state, { session, stored, time }) {
  const left = viewCount({ session: state.session, stored }) / Math.max(1, viewCount(state));
  const next = session ? { ...inSession(state, session), progress: session.progress } : { ...state, progress: state.progress * left };
  return notify({ ...next, stored, busy: false, answered: null }, { key: "capture.view_undone", kind: "good" }, time);
}

/** @param {[number, number]} size of a frame, px @param {CameraKey | null} key */
export function isOfSize([width, height], key) {
  return width === key?.img_size[0] && height === key.img_size[1];
}

/** @param {[number, number][] | null} outline @param {Pose | null} pose @param {CameraKey | null} key */
function overlap(outline, pose, key) {
  return outline && pose && key ? jaccard(outline, pose.outline, key.img_size) : 0;
}
