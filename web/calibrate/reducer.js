// Reducer of the guided capture: `(state, event) => state`. No clock, no DOM, no network.
import { BLIND, HEALTHY, aimAt, doubt, isThere, observeFrame } from "../lib/capture/sight.js";
import { HINTS, SILENT, instruct, isRepeat, requiredHold, timeToRead } from "./guidance.js";
import { isOfSize, offlineGoal, viewCount } from "./state.js";
import { MOVING, motion } from "../lib/capture/stillness.js";
import { HOLD_MS, LONG_HOLD_MS, asMirrored, lenienceAfter } from "../lib/capture/target.js";

/**
 * @import { SessionState, ViewAnswer } from "../lib/session.js"
 * @import { Board, Event, Notice, State, Wanted } from "./state.js"
 */

/** @template {Event["type"]} T @typedef {Extract<Event, {type: T}>} EventOf */

const NOTICE_MS = 4_000;
const CONFIRM_STOP_MS = 5_000; // in which a second press stops the capture
const MAX_UNCONFIRMED_PROGRESS = 0.95; // until the service says that the capture is complete
const BOARDLESS_MS = 8_000; // without any marker, before a way to get a board is offered
const MAX_FRAME_MS = 500; // longest time that one frame counts for
const STEADY_PX = 2; // px at 1280 px image width, during a hold: less is no motion of the board or the camera
const DONE = { code: "wait", next: "wait", since: 0 }; // the view is taken: the visitor need not hold still any more
const MIN_APPROACH = 0.05; // of the distance to the target that counts as coming nearer
/** Reasons for a refusal that have a message. */
const EXPLAINED_REASONS = new Set([
  "too_few_points",
  "degenerate",
  "mirrored",
  "outlier",
  "duplicate",
  "no_information",
]);

/** @param {Board} board @param {Wanted} wanted @returns {State} */
export function initial(board, wanted) {
  return {
    phase: "welcome",
    board,
    wanted,
    failure: null,
    capture: {
      key: null,
      request: null,
      mirrored: false,
      cropped: false,
      session: null,
      initialViews: 0,
      progress: 0,
      posedAt: 0,
      takenAt: 0,
      nearest: { time: 0, distance: Infinity },
      lastRepeat: null,
      taken: [],
      repeats: 0,
      skipAfter: null,
      unsteady: false,
    },
    link: { busy: false, attempts: 0, offline: false, stored: 0, sending: false },
    sight: BLIND,
    detector: { loading: 0, stalled: false, boardless: false, suggestion: null, looks: 0, restless: 0 },
    ui: {
      cameras: [],
      interrupted: null,
      waiting: "camera",
      instruction: SILENT,
      notice: null,
      noticedAt: 0,
      openingNotice: null,
      picture: null,
      plain: false,
      saved: true,
      boardWanted: false,
      stopAskedAt: null,
    },
  };
}

/**
 * @param {State} state @param {{capture?: Partial<State["capture"]>, link?: Partial<State["link"]>,
 *   sight?: Partial<State["sight"]>, detector?: Partial<State["detector"]>, ui?: Partial<State["ui"]>}} changes of
 *   its parts
 * @returns {State}
 */
function change(state, { capture, link, sight, detector, ui }) {
  return {
    ...state,
    capture: capture ? { ...state.capture, ...capture } : state.capture,
    link: link ? { ...state.link, ...link } : state.link,
    sight: sight ? { ...state.sight, ...sight } : state.sight,
    detector: detector ? { ...state.detector, ...detector } : state.detector,
    ui: ui ? { ...state.ui, ...ui } : state.ui,
  };
}

/** @param {State} state @param {Event} event @returns {State} */
export function reduce(state, event) {
  switch (event.type) {
    case "cameras":
      return change(state, { ui: { cameras: event.cameras } });
    case "interrupted":
      return change(state, { ui: { interrupted: event.interrupted } });
    case "open":
      return open(state, event.notice ?? null);
    case "board":
      return { ...state, board: event.board };
    case "waiting":
      return change(state, { ui: { waiting: event.waiting } });
    case "loading":
      return change(state, { detector: { loading: event.fraction } });
    case "opened": {
      const { key, request = null, mirrored, cropped } = event;
      return change(state, { capture: { key, request, mirrored, cropped }, sight: { size: key.img_size } });
    }
    case "request":
      return change(state, { capture: { request: event.request } });
    case "model":
      return {
        ...state,
        phase: state.phase === "welcome" ? "welcome" : "opening",
        wanted: { ...state.wanted, distortion_model: event.model, automatic: event.automatic ?? false },
      };
    case "opened-offline":
      return openOffline(state, event);
    case "session":
      return start(
        state,
        change(followSession(state, event.session), { link: { stored: event.stored ?? 0 } }),
        event.time,
      );
    case "pose":
      return setTarget(state, event);
    case "frame":
      return state.phase === "capturing" ? follow(state, event) : state;
    case "looked":
      if (state.sight.corners.ids.length > 0) return state;
      return change(state, {
        sight: doubt(state.sight, event.suggestion, state.board, event.time),
        detector: { suggestion: event.suggestion, looks: state.detector.looks + 1 },
      });
    case "flip":
      return { ...state, wanted: { ...state.wanted, flipped: !state.wanted.flipped } };
    case "busy":
      return change(state, { link: { busy: true } });
    case "idle":
      return change(state, { link: { busy: false } });
    case "sent":
      return change(state, {
        capture: { unsteady: state.capture.unsteady || isUnsteady(state.sight, event.corners) },
        sight: { lastTaken: event.corners },
        detector: { restless: 0 },
        ui: { instruction: DONE },
      });
    case "answer":
      return takeAnswer(state, event);
    case "stored":
      return storeView(state, event);
    case "undone":
      return undo(state, event);
    case "retrying":
      // A notice about the last view is outdated, and would look like the state of the connection.
      return change(state, {
        link: { attempts: event.attempts },
        ui: { notice: event.attempts > 0 ? null : state.ui.notice },
      });
    case "offline":
      // The status line already says that the service is away, so there is no notice.
      return change(clearTarget(state), {
        link: { offline: true, stored: event.stored, attempts: 0, busy: false },
        ui: { notice: null },
      });
    case "sending":
      return change(state, { link: { sending: event.sending } });
    case "online":
      return notify(
        change(clearTarget(followSession(state, event.session)), {
          capture: { takenAt: event.time },
          link: { offline: false, sending: false, stored: 0, attempts: 0 },
        }),
        onlineNotice(event),
        event.time,
      );
    case "stalled":
      return change(state, { detector: { stalled: event.stalled } });
    case "visible":
      // Time in a hidden tab does not count.
      return change(state, {
        capture: { posedAt: event.time, takenAt: event.time, nearest: { ...state.capture.nearest, time: event.time } },
        sight: { stillness: MOVING, diagnosis: HEALTHY },
      });
    case "unsaved":
      return change(state, { ui: { saved: false } });
    case "slow":
      return change(state, { ui: { plain: true } });
    case "want-board":
      return change(state, { ui: { boardWanted: true } });
    case "notice":
      return notify(state, event.notice, event.time);
    case "stop":
      return stop(state, event.time);
    case "failed":
      return change(
        { ...state, phase: "failed", failure: { code: event.code, detail: event.detail ?? "" } },
        { link: { busy: false, attempts: 0 } },
      );
    case "restart":
      return reset(state);
  }
}

/** Resets everything except the page's own state. @param {State} state @returns {State} */
function reset({ board, wanted, detector: { loading }, ui: { cameras, interrupted, plain } }) {
  return change(initial(board, wanted), { detector: { loading }, ui: { cameras, interrupted, plain } });
}

/**
 * The last session, if any, is named until the service answers: it may be resumed.
 * @param {State} state
 * @param {Notice | null} notice
 */
function open(state, notice) {
  const {
    capture: { session },
    link: { stored },
  } = state;
  return change(
    { ...reset(state), phase: "opening" },
    { capture: { session }, link: { stored }, ui: { openingNotice: notice } },
  );
}

/** @param {State} state @param {EventOf<"opened-offline">} event @returns {State} */
function openOffline(state, { stored, time }) {
  const progress = MAX_UNCONFIRMED_PROGRESS * Math.min(1, stored / offlineGoal({ capture: { session: null } }));
  const next = change(
    { ...state, phase: "capturing" },
    {
      capture: { session: null, progress },
      link: { offline: true, stored, attempts: 0 },
    },
  );
  return start(state, next, time);
}

/**
 * A capture that runs from now on counts its views, and says why it was opened.
 * @param {State} before
 * @param {State} state
 * @param {number} time
 */
function start(before, state, time) {
  if (before.phase === "capturing") return state;
  const started = change(state, {
    capture: { initialViews: viewCount(state), takenAt: time },
    ui: { openingNotice: null },
  });
  const { openingNotice } = state.ui;
  return openingNotice && state.phase === "capturing" ? notify(started, openingNotice, time) : started;
}

/** @param {State} state @param {Notice} notice @param {number} time @returns {State} */
const notify = (state, notice, time) => change(state, { ui: { notice, noticedAt: time } });

/** @param {State} state @returns {State} */
const clearTarget = (state) => change(state, { sight: aimAt(state.sight, null, state.board), ui: { picture: null } });

/**
 * True if the corners moved while a view was held.
 * @param {State["sight"]} sight
 * @param {import("../lib/board-outline.js").Corners} corners that were taken
 */
const isUnsteady = ({ stillness: { anchor }, size }, corners) =>
  anchor !== null && motion(anchor, corners) > (STEADY_PX * size[0]) / 1280;

/**
 * A stored view brings the capture nearer to its end, as far as the page knows without the service.
 * @param {State} state
 * @param {EventOf<"stored">} event
 */
function storeView(state, { corners, stored, time }) {
  const left = Math.max(0, MAX_UNCONFIRMED_PROGRESS - state.capture.progress);
  const progress = state.capture.progress + left / Math.max(1, offlineGoal(state) - state.link.stored);
  const next = change(clearTarget(state), {
    capture: {
      lastRepeat: null,
      taken: [...state.capture.taken, corners],
      progress,
      unsteady: state.capture.unsteady || isUnsteady(state.sight, corners),
    },
    sight: { lastTaken: corners },
    link: { stored, busy: false },
    ui: { instruction: DONE },
  });
  return notify(next, { key: "capture.view_stored", kind: "good" }, time);
}

/**
 * Notice about the stored views: taken or refused.
 * @param {{taken: number, refused: number}} event
 * @returns {Notice}
 */
function onlineNotice({ taken, refused }) {
  if (refused) return { key: "capture.came_back_less", kind: "good", values: { count: refused } };
  return { key: taken ? "capture.came_back" : "capture.came_back_only", kind: "good" };
}

/** Only a second press loses views. @param {State} state @param {number} time @returns {State} */
function stop(state, time) {
  if (state.phase !== "capturing" || viewCount(state) === 0 || state.ui.stopAskedAt !== null) return reset(state);
  const notice = /** @type {Notice} */ ({
    key: "capture.press_again",
    kind: "plain",
    values: { count: viewCount(state) },
  });
  return notify(change(state, { ui: { stopAskedAt: time } }), notice, time);
}

/** @param {State} state @param {SessionState} session @returns {State} */
function followSession(state, session) {
  const done = session.status === "converged";
  const progress = done ? 1 : Math.max(state.capture.progress, session.progress);
  const next = change({ ...state, phase: done ? "done" : "capturing" }, { capture: { session, progress } });
  return done ? clearTarget(next) : next;
}

/** @param {State} state @param {EventOf<"pose">} event @returns {State} */
function setTarget(state, { pose, picture, time }) {
  const next = change(state, {
    capture: { posedAt: time, skipAfter: null, nearest: { time, distance: Infinity } },
    link: { busy: false },
    sight: aimAt(state.sight, pose, state.board),
    ui: { picture },
  });
  // The last instruction was about another target: the visitor need not hold still for it any more.
  if (!next.sight.outline) return next;
  const silent = change(next, { ui: { instruction: SILENT } });
  return change(next, { ui: { instruction: instruct(silent, requiredHold(next) === HOLD_MS, time) } });
}

/** @param {State} state @param {EventOf<"frame">} event @returns {State} */
function follow(state, { detection, time }) {
  const { ids, markers, size } = detection;
  const { capture, detector, ui } = state;
  if (!isOfSize(size, capture.key)) return reduce(state, { type: "failed", code: "resized" });
  const sight = observeFrame(state.sight, detection, time, state.board, lenienceAfter(time - capture.posedAt));
  const { corners, stillness, diagnosis, distance } = sight;
  const { stopAskedAt } = ui;
  const next = change(state, {
    sight,
    detector: {
      boardless: markers === 0 && !diagnosis.other && time - diagnosis.blindSince > BOARDLESS_MS,
      ...(ids.length > 0 && { suggestion: null, looks: 0 }),
      restless:
        stillness.held >= LONG_HOLD_MS
          ? 0
          : detector.restless + (ids.length > 0 ? Math.min(MAX_FRAME_MS, time - state.sight.diagnosis.seenAt) : 0),
    },
    ui: {
      boardWanted: ui.boardWanted && ids.length === 0,
      notice: time - ui.noticedAt > NOTICE_MS ? null : ui.notice,
      stopAskedAt: stopAskedAt !== null && time - stopAskedAt > CONFIRM_STOP_MS ? null : stopAskedAt,
    },
  });
  const nearest = distance < capture.nearest.distance - MIN_APPROACH ? { time, distance } : capture.nearest;
  const after = change(next, {
    capture: { nearest },
    ui: { instruction: instruct(next, requiredHold(next) === HOLD_MS, time) },
  });
  if (!isRepeat(state.sight.stillness.held, after)) return after;
  const duplicate = change(after, { capture: { lastRepeat: corners, repeats: capture.repeats + 1 } });
  return notify(duplicate, { key: "capture.refused_duplicate", kind: "bad" }, time);
}

/** @param {State} state @param {EventOf<"answer">} event @returns {State} */
function takeAnswer(state, { answer, corners, time }) {
  // An outlier needs other views to contradict. A lone view that does not fit is degenerate.
  const reason = answer.reason === "outlier" && answer.views.length === 0 ? "degenerate" : answer.reason;
  // A visitor at the target is not asked to go there.
  const useless = (reason === "no_information" || reason === "duplicate") && isThere(state.sight);
  const { taken, repeats, takenAt } = state.capture;
  const isIn = answer.accepted || reason === "duplicate";
  const next = change(followSession(state, answer), {
    capture: {
      lastRepeat: null,
      taken: isIn ? [...taken, corners] : taken,
      repeats: answer.accepted ? 0 : repeats + Number(reason === "duplicate"),
      skipAfter: answer.accepted || !isThere(state.sight) ? null : timeToRead(useless),
      takenAt: answer.accepted ? time : takenAt,
    },
    sight: { lastTaken: corners },
    link: { busy: false },
  });
  // After an accepted view, its target disappears at once and the next one is fetched. A refused view keeps it.
  const after = answer.accepted ? clearTarget(next) : next;
  return notify(after, answerNotice(state, answer, useless ? "useless" : reason), time);
}

/** @param {State} state @param {ViewAnswer} answer @param {string | null} reason @returns {Notice} */
function answerNotice({ capture }, answer, reason) {
  if (!answer.accepted) {
    if (reason === "useless") return { key: "capture.useless", kind: "plain" };
    const key = EXPLAINED_REASONS.has(reason ?? "") ? `capture.refused_${reason}` : "capture.refused";
    const hint = answer.hint && HINTS.has(answer.hint.code) ? answer.hint.code : undefined;
    return { key, kind: "bad", ...(hint && { hint: capture.mirrored ? asMirrored(hint) : hint }) };
  }
  const before = new Set(capture.session?.views.filter(({ set_aside }) => set_aside).map(({ index }) => index));
  const aside = answer.views.find(({ index, set_aside }) => set_aside && !before.has(index));
  if (aside)
    return { key: "capture.view_set_aside", kind: "plain", values: { number: answer.views.indexOf(aside) + 1 } };
  const isAside = answer.views.at(-1)?.on_target === false;
  return {
    key: isAside ? "capture.view_taken_aside" : "capture.view_taken",
    kind: "good",
    values: { number: answer.views.length },
  };
}

/** @param {State} state @param {EventOf<"undone">} event @returns {State} */
function undo(state, { session, stored, time }) {
  const { progress } = state.capture;
  const left = viewCount({ ...state, link: { ...state.link, stored } }) / Math.max(1, viewCount(state));
  const next = session
    ? change(followSession(state, session), { capture: { progress: session.progress } })
    : change(state, { capture: { progress: progress * left } });
  const undone = change(next, {
    capture: { lastRepeat: null, taken: [], repeats: 0, takenAt: time },
    sight: { lastTaken: null },
    link: { stored, busy: false },
  });
  return notify(undone, { key: "capture.view_undone", kind: "good" }, time);
}
