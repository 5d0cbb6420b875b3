// State of the guided capture: its parts, the events that change it, and what follows from it. No clock, no DOM, no
// network.

/**
 * @import { Corners } from "../lib/board-outline.js"
 * @import { Recognised } from "../lib/board-recognition.js"
 * @import { Choice, LensType } from "../lib/camera.js"
 * @import { Detection } from "../lib/detector.js"
 * @import { Pose, SessionRequest, SessionState, ViewAnswer } from "../lib/session.js"
 * @import { CameraKey } from "../sdk/calibdb.js"
 */

/**
 * @typedef {import("../lib/board.js").SentBoard} Board
 * @typedef {import("../lib/capture/target.js").Instruction} Instruction
 *
 * @typedef {object} Wanted the camera that the page was opened for
 * @property {string | null} camera
 * @property {[number, number] | null} img_size
 * @property {LensType} distortion_model
 * @property {boolean} [flipped] the camera delivers mirrored pictures, which are turned back
 * @property {boolean} [automatic] another model is taken as soon as the service suggests it
 *
 * @typedef {{key: string, kind: "good" | "bad" | "plain", values?: Record<string, string | number>, hint?: string}}
 *   Notice key: of a message; hint: the instruction that would help
 *
 * @typedef {object} State
 * @property {"welcome" | "opening" | "capturing" | "done" | "failed"} phase
 * @property {Board} board
 * @property {Wanted} wanted
 * @property {{code: string, detail: string} | null} failure a message `capture.fault_<code>`
 * @property {Capture} capture
 * @property {Link} link
 * @property {import("../lib/capture/sight.js").Sight<Pose>} sight of the board
 * @property {Detector} detector
 * @property {Ui} ui
 *
 * @typedef {object} Capture the open camera, its session and its current target
 * @property {CameraKey | null} key of the open camera
 * @property {SessionRequest | null} request body of POST /v1/session
 * @property {boolean} mirrored the preview is mirrored
 * @property {boolean} cropped the browser crops or scales the sensor's image
 * @property {SessionState | null} session
 * @property {number} initialViews view count when the capture was started or resumed
 * @property {number} progress 0…1, never falls but by an undo
 * @property {number} posedAt ms, when the target was set
 * @property {number} takenAt ms, when the last view was taken, or the capture began
 * @property {{time: number, distance: number}} nearest smallest distance to the target so far, and when
 * @property {Corners | null} lastRepeat corners of the last hold that showed nothing new: it counts once
 * @property {Corners[]} taken corners of the holds whose views are in
 * @property {number} repeats holds in a row that showed nothing new
 * @property {boolean} unsteady the corners moved while one of the views was held
 * @property {number | null} skipAfter ms after a refusal in the target's place, before another target is requested
 *
 * @typedef {object} Link the connection to the service
 * @property {boolean} busy a request is in flight
 * @property {number} attempts failed attempts since the service last answered
 * @property {boolean} offline the service cannot be reached: targets come from the page's own plan
 * @property {number} stored views that wait on this device
 * @property {boolean} sending the service is back, and the stored views are being sent
 *
 * @typedef {object} Detector the board detector, and what it has seen over time
 * @property {number} loading 0…1, how much of OpenCV has arrived
 * @property {boolean} stalled it has stopped, and is restarted
 * @property {boolean} boardless nothing of any board has been seen for so long that there may be none
 * @property {Recognised | null} suggestion what is seen instead of the board
 * @property {number} restless ms for which the board has been seen without being held still
 * @property {number} looks frames in which anything else was looked for, since the board was seen last
 *
 * @typedef {object} Ui
 * @property {Choice[]} cameras
 * @property {{camera: string, views: number, about: string, address: string} | null} interrupted a capture that an
 *   earlier page left on this device; about: its key in the capture store
 * @property {"camera" | "service"} waiting what a capture that is being opened waits for
 * @property {Instruction} instruction
 * @property {Notice | null} notice
 * @property {number} noticedAt ms
 * @property {Notice | null} openingNotice shown as soon as the capture runs
 * @property {string | null} picture object URL of the target's overlay
 * @property {boolean} plain this device is too slow for the coloured overlay
 * @property {boolean} saved views could be saved on this device
 * @property {boolean} boardWanted the visitor asked how to get the expected board; until a board is seen
 * @property {number | null} stopAskedAt ms, when a stop was requested that would lose views
 *
 * @typedef {{type: "cameras", cameras: Choice[]}
 *   | {type: "interrupted", interrupted: Ui["interrupted"]}
 *   | {type: "open", notice?: Notice}
 *   | {type: "board", board: Board}
 *   | {type: "waiting", waiting: Ui["waiting"]}
 *   | {type: "loading", fraction: number}
 *   | {type: "opened", key: CameraKey, request?: Capture["request"], mirrored: boolean, cropped: boolean}
 *   | {type: "session", session: SessionState, stored?: number, time: number}
 *   | {type: "request", request: Capture["request"]}
 *   | {type: "model", model: Wanted["distortion_model"], automatic?: boolean}
 *   | {type: "opened-offline", stored: number, time: number}
 *   | {type: "pose", pose: Pose, picture: string | null, time: number}
 *   | {type: "frame", detection: Detection, time: number}
 *   | {type: "looked", suggestion: Recognised | null, time: number}
 *   | {type: "flip"}
 *   | {type: "busy"}
 *   | {type: "idle"}
 *   | {type: "sent", corners: Corners}
 *   | {type: "answer", answer: ViewAnswer, corners: Corners, time: number}
 *   | {type: "stored", corners: Corners, stored: number, time: number}
 *   | {type: "undone", session: SessionState | null, stored: number, time: number}
 *   | {type: "retrying", attempts: number}
 *   | {type: "offline", stored: number}
 *   | {type: "sending", sending: boolean}
 *   | {type: "online", session: SessionState, taken: number, refused: number, time: number}
 *   | {type: "stalled", stalled: boolean}
 *   | {type: "visible", time: number}
 *   | {type: "unsaved"}
 *   | {type: "slow"}
 *   | {type: "want-board"}
 *   | {type: "notice", notice: Notice, time: number}
 *   | {type: "stop", time: number}
 *   | {type: "failed", code: string, detail?: string}
 *   | {type: "restart"}} Event
 *
 * @typedef {{capture: Pick<Capture, "session">, link: Pick<Link, "offline" | "stored">}} Views
 */

const MIN_VIEWS_OFFLINE = 8; // in all: enough for a good fit although no pose was chosen for it
const MIN_STORED_OFFLINE = 3; // stored while offline, however many views the service already has

/** @param {string} key of a message @param {Record<string, string | number>} [values] @returns {Notice} */
export const plainNotice = (key, values) => ({ key, kind: "plain", values });

export const MIN_VIEWS = 4; // of which the service makes a calibration
const USUAL_VIEWS = 5; // of a capture
const IDLE_MS = 30_000; // without another view, after which a capture ends with those that are there
const MAX_REPEATS = 4; // holds in a row that show nothing new, after which it ends likewise

/** Number of views that take part in the fit. @param {SessionState | null} session */
const usedViews = (session) => session?.views.filter(({ set_aside }) => !set_aside).length ?? 0;

/**
 * Number of views taken, here and at the service.
 * @param {{capture: Pick<Capture, "session">, link: Pick<Link, "stored">}} state
 */
export const viewCount = ({ capture: { session }, link: { stored } }) => usedViews(session) + stored;

/** True if the error that is expected is below the goal. @param {{capture: Pick<Capture, "session">}} state */
export const isAccurate = ({ capture: { session } }) =>
  session?.uncertainty != null && session.uncertainty.rms < session.target_error;

/**
 * Number of views that the capture will probably take.
 * @param {{capture: Pick<Capture, "session">, link: Pick<Link, "stored">}} state
 */
export const expectedViews = (state) =>
  isAccurate(state) ? Math.max(MIN_VIEWS, viewCount(state)) : Math.max(USUAL_VIEWS, viewCount(state) + 1);

/**
 * True if the visitor can end the capture: the service has enough views for a result, even a poor one.
 * @param {Views} state
 */
export const isFinishable = ({ capture: { session }, link: { offline, stored } }) =>
  !offline && stored === 0 && session?.calibration != null && usedViews(session) >= MIN_VIEWS;

// of a moving board, before the page says that views need a still one
const NEVER_STILL_MS = 12_000;
const SHARPEST_MS = 60_000; // of a moving board, before the page offers the sharpest frames as views

/** True if the board is in view, and is never held still. @param {State} state */
export const isRestless = ({ detector: { restless } }) => restless > NEVER_STILL_MS;

/** True if the sharpest frames so far can be used as views. @param {State} state */
export const isSharpestOffered = ({ phase, detector: { restless }, link: { offline } }) =>
  phase === "capturing" && !offline && restless > SHARPEST_MS;

/**
 * True if the board has shown nothing new so often, or for so long, that the capture ends with the views it has.
 * @param {State} state
 * @param {number} time ms
 */
export const isExhausted = (state, time) =>
  isFinishable(state) && (state.capture.repeats >= MAX_REPEATS || time - state.capture.takenAt > IDLE_MS);

/** Number of views to store while offline. @param {{capture: Pick<Capture, "session">}} state */
export const offlineGoal = ({ capture: { session } }) =>
  Math.max(MIN_STORED_OFFLINE, MIN_VIEWS_OFFLINE - usedViews(session));

/** True if enough views are stored to wait for the service. @param {Views} state */
export const isEnough = (state) => state.link.offline && state.link.stored >= offlineGoal(state);

/**
 * Key of a capture, from its request but for the track's settings (focus changes).
 * @param {SessionRequest} request
 */
export const captureKey = ({ track, mode_name, ...request }) => JSON.stringify(request);

/** @param {[number, number]} size of a frame, px @param {CameraKey | null} key */
export const isOfSize = ([width, height], key) => width === key?.img_size[0] && height === key.img_size[1];
