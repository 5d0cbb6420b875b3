// Sight of the board in one camera, frame by frame: where the board is, how still it is held, how far it is from its
// target, and what keeps it from being seen. Pure: the time comes in.
import { observedOutline } from "../board-outline.js";
import { advice, asMirrored, difference, jaccard } from "./target.js";
import { MOVING, motion, observe } from "./stillness.js";
import { isSameBoard } from "../board.js";

/**
 * @import { Corners } from "../board-outline.js"
 * @import { Recognised } from "../board-recognition.js"
 * @import { Board, SentBoard } from "../board.js"
 * @import { Detection } from "../detector.js"
 */

/**
 * @typedef {{ids: number[], corners: number[][], outline: number[][]}} Target px
 */

/**
 * Diagnosis of a board that is not seen, or not seen well, from frame metrics over time.
 * @typedef {object} Diagnosis
 * @property {string | null} trouble what is said: "dark", "bright", "blurred", "far", "wrong_board", "legacy",
 *   "mirrored", "moire", "moving"
 * @property {string | null} suspected what the last frames look like
 * @property {number} since ms, when it was first suspected
 * @property {number} blindSince ms, since when no corner has been seen; infinite while some are
 * @property {boolean} illegible the last frame is blurred, or shows markers whose squares are too small to be measured
 * @property {string | null} other trouble that another board or a mirrored picture is; it stands until corners are seen
 * @property {number} seenAt ms, when the frame before was seen
 * @property {{time: number, speed: number}[]} speeds px/s at 1280 px image width, of the last frames with a board
 */

/** @type {Diagnosis} */
export const HEALTHY = {
  trouble: null,
  suspected: null,
  since: 0,
  blindSince: Infinity,
  illegible: false,
  other: null,
  seenAt: -Infinity,
  speeds: [],
};

/**
 * @template {Target} [T=Target]
 * @typedef {object} Sight
 * @property {[number, number]} size of the image, px
 * @property {Corners} corners of the last frame
 * @property {number} markers in the last frame
 * @property {[number, number][] | null} outline of the board in the last frame, px
 * @property {import("./stillness.js").Stillness} stillness
 * @property {Diagnosis} diagnosis
 * @property {T | null} target
 * @property {[number, number][] | null} aim the target's outline, px; null where too little of it is in the image
 * @property {number} overlap with the target, Jaccard index
 * @property {number} distance from the target: 0 there, infinite where the two cannot be compared
 * @property {Corners | null} lastTaken corners of the hold that was taken last: the same hold is not taken twice
 */

const MIN_OVERLAP = 0.6; // Jaccard index with the target that counts as there,
const MAX_DIFFERENCE = 0.08; // if the board is also tilted as the target is
const MIN_DISPLACEMENT_PX = 26; // at 1280 px image width: the service refuses duplicates within 25.6
const SETTLED_MS = 300; // of holding still before the camera's focus is locked: less than a view takes
const MIN_VISIBLE_SHARE = 0.6; // of the board's corners from which the lens is taken to be focused on it,
const PART_SETTLED_MS = 900; // or after so long a hold: a camera of a rig may never see more of the board

/** @type {Sight<any>} */
export const BLIND = {
  size: [1280, 720],
  corners: { ids: [], points: [] },
  markers: 0,
  outline: null,
  stillness: MOVING,
  diagnosis: HEALTHY,
  target: null,
  aim: null,
  overlap: 0,
  distance: Infinity,
  lastTaken: null,
};

/**
 * @template {Target} T
 * @param {Sight<T>} before @param {Detection} detection @param {number} time ms
 * @param {Board} board
 * @param {number} [lenience] how many times a steady hand's motion counts as still
 * @returns {Sight<T>}
 */
export function observeFrame(before, detection, time, board, lenience = 1) {
  const { ids, points, markers, size } = detection;
  const found = { ids, points };
  const stillness = observe(before.stillness, found, time, size[0], lenience);
  // A blurred frame in the middle of a hold is ignored, or the hold would begin again.
  const passed = stillness === before.stillness;
  const corners = passed ? before.corners : found;
  return measured({
    ...before,
    size,
    corners,
    outline: passed ? before.outline : observedOutline(board, corners),
    stillness,
    markers: passed ? before.markers : markers,
    diagnosis: diagnose(before.diagnosis, detection, motion(before.corners, found), time),
  });
}

/**
 * Another board, or a mirrored picture, is reported at once: several detections agree on it. A board that is blurred,
 * or too far away to be read, may look like any other.
 * @template {Target} T
 * @param {Sight<T>} sight @param {Recognised | null} suggestion what is there
 *   instead of the board
 * @param {SentBoard} board @param {number} time ms
 * @returns {Sight<T>}
 */
export function doubt(sight, suggestion, board, time) {
  if (!suggestion || sight.corners.ids.length > 0 || sight.diagnosis.illegible) return sight;
  const trouble = troubleOf(suggestion, board);
  return {
    ...sight,
    diagnosis: { ...sight.diagnosis, other: trouble, suspected: trouble, trouble, since: time },
  };
}

/**
 * Gives a camera its target, or none.
 * @template {Target} T
 * @param {Sight<T>} sight @param {T | null} target @param {Board} board
 * @returns {Sight<T>}
 */
export function aimAt(sight, target, board) {
  const aim = target && observedOutline(board, { ids: target.ids, points: target.corners });
  return measured({ ...sight, target, aim });
}

/** @template {Target} T @param {Sight<T>} sight @returns {Sight<T>} */
function measured(sight) {
  const { outline, target, aim, size } = sight;
  const overlap = outline && target ? jaccard(outline, target.outline, size) : 0;
  const distance = outline && aim ? 1 - overlap + difference(outline, aim) : Infinity;
  return { ...sight, overlap, distance };
}

/** True if the board is at its target, and tilted as the target is. @param {Sight} sight */
export const isThere = ({ outline, overlap, aim }) =>
  overlap > MIN_OVERLAP && outline !== null && (aim === null || difference(outline, aim) < MAX_DIFFERENCE);

/** True if the board is where it was held then. @param {Sight} sight @param {Corners | null} hold */
export const isNear = ({ corners, size }, hold) =>
  hold !== null && motion(hold, corners) < (MIN_DISPLACEMENT_PX * size[0]) / 1280;

/**
 * Code of the movement that leads to the target, as the preview shows it; "match": none stands out.
 * @param {Sight} sight @param {boolean} isMirrored the preview is a mirror
 * @param {string} [otherwise] code if board and target cannot be compared
 */
export function movement({ outline, aim }, isMirrored, otherwise = "match") {
  const code = outline && aim ? advice(outline, aim) || "match" : otherwise;
  return isMirrored ? asMirrored(code) : code;
}

/**
 * True if the board is held before the camera and is in focus, so that the focus may be locked.
 * @param {Sight} sight @param {Board} board
 */
export function isSettled({ corners, diagnosis, stillness }, { squares: [columns, rows] }) {
  const isMostlySeen = corners.ids.length >= MIN_VISIBLE_SHARE * (columns - 1) * (rows - 1);
  return diagnosis.suspected === null && stillness.held >= (isMostlySeen ? SETTLED_MS : PART_SETTLED_MS);
}

const PERSISTS = 700; // ms that something must look wrong before it is said
const DARK = 40; // of 255: the brighter parts of the picture (95 %) are below twice this
const BURNT = 0.25; // share of the picture that is white without structure
const BLURRED = 0.072; // sharpness of a picture with edges: below, a square's edge is wider than about 6 px
// share of the corners: blur loses them before it moves them (half of them at 0.2 px), so while they are found, none is
// said
const WHOLE = 0.5;
const SMALL = 16; // px: side of a square below which corners cannot be measured
const STRIPES = 0.1; // standard deviation within the bright squares, of their contrast: harmful stripes have more
const FAST = 360; // px/s at 1280 px image width: a rolling shutter bends what moves so fast
const RECENT = 800; // ms over which speed is taken
const MIN_SPEEDS = 3; // frames with a speed: one alone may be a wrong corner

/**
 * @param {Diagnosis} before
 * @param {Detection} detection
 * @param {number} motion px since the frame before, infinite where
 *   the two cannot be compared
 * @param {number} time ms
 * @returns {Diagnosis}
 */
export function diagnose(before, detection, motion, time) {
  const { ids, size } = detection;
  const blind = ids.length === 0;
  const blindSince = blind ? Math.min(before.blindSince, time) : Infinity;
  const speed = (1000 * motion * 1280) / (size[0] * (time - before.seenAt));
  const speeds = blind
    ? []
    : [...before.speeds, { time, speed }].filter((each) => Number.isFinite(each.speed) && time - each.time < RECENT);
  const other = blind ? before.other : null;
  const suspected = suspect(detection, blindSince === Infinity ? 0 : time - blindSince, other, speeds);
  const since = suspected === before.suspected ? before.since : time;
  return {
    trouble:
      time - since >= PERSISTS ? suspected : before.trouble === suspected ? suspected : stillSaid(before, suspected),
    suspected,
    since,
    blindSince,
    speeds,
    illegible: isTiny(detection) || isBlurred(detection),
    other,
    seenAt: time,
  };
}

/**
 * Keep a diagnosis until its successor is sure, but not once the board is well seen.
 * @param {Diagnosis} before
 * @param {string | null} suspected
 */
const stillSaid = (before, suspected) => (suspected === null ? null : before.trouble);

/** @param {Pick<Detection, "markers" | "metrics">} detection */
const isTiny = ({ markers, metrics }) =>
  markers > 0 && metrics !== undefined && metrics.square > 0 && metrics.square < SMALL;

/** @param {Pick<Detection, "metrics">} detection */
const isBlurred = ({ metrics }) => typeof metrics?.sharpness === "number" && metrics.sharpness < BLURRED;

/**
 * @param {Detection} detection @param {number} blind ms without a corner @param {string | null} other
 * @param {Diagnosis["speeds"]} speeds
 * @returns {string | null}
 */
function suspect({ ids, markers, metrics }, blind, other, speeds) {
  if (!metrics) return null;
  if (ids.length === 0) {
    if (blind < PERSISTS) return null;
    if (other) return other;
    if (isTiny({ markers, metrics })) return "far";
    if (metrics.high < 2 * DARK && metrics.median < DARK) return "dark";
    if (metrics.overexposed > BURNT) return "bright";
    return isBlurred({ metrics }) ? "blurred" : null;
  }
  if (metrics.square > 0 && metrics.square < SMALL) return "far";
  if (speeds.length >= MIN_SPEEDS && median(speeds.map(({ speed }) => speed)) > FAST) return "moving";
  if (metrics.share < WHOLE && isBlurred({ metrics })) return "blurred";
  return metrics.moire !== null && metrics.moire > STRIPES ? "moire" : null;
}

/** @param {number[]} values */
const median = (values) => [...values].sort((a, b) => a - b)[values.length >> 1] ?? 0;

/**
 * The trouble that another board is, as the diagnosis names it.
 * @param {Recognised} suggestion
 * @param {SentBoard} expected
 */
export function troubleOf({ board, mirrored }, expected) {
  if (mirrored) return "mirrored";
  return isSameBoard(board, { ...expected, legacy: !expected.legacy }) ? "legacy" : "wrong_board";
}
