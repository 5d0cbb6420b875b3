// Diagnosis of a board that is not seen, or not seen well, from frame metrics over time. Pure: the time comes in.
import { isSameBoard } from "../board.js";

/**
 * @typedef {import("../detector.js").Detection} Detection
 *
 * @typedef {object} Diagnosis
 * @property {string | null} trouble what is said: "dark", "bright", "blurred", "far", "wrong_board", "legacy",
 *   "mirrored", "moire", "moving"
 * @property {string | null} suspected what the last frames look like
 * @property {number} since ms, when it was first suspected
 * @property {number} blindSince ms, since when no corner has been seen; infinite while some are
 * @property {boolean} tiny markers are seen in the last frame, and their squares are too small to be measured
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
  tiny: false,
  other: null,
  seenAt: -Infinity,
  speeds: [],
};

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
    tiny: isTiny(detection),
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
    return metrics.sharpness !== null && metrics.sharpness < BLURRED ? "blurred" : null;
  }
  if (metrics.square > 0 && metrics.square < SMALL) return "far";
  if (speeds.length >= MIN_SPEEDS && median(speeds.map(({ speed }) => speed)) > FAST) return "moving";
  if (metrics.share < WHOLE && metrics.sharpness !== null && metrics.sharpness < BLURRED) return "blurred";
  return metrics.moire !== null && metrics.moire > STRIPES ? "moire" : null;
}

/** @param {number[]} values */
const median = (values) => [...values].sort((a, b) => a - b)[values.length >> 1] ?? 0;

/**
 * The trouble that another board is, as the diagnosis names it.
 * @param {import("../board-recognition.js").Recognised} suggestion
 * @param {import("../board.js").SentBoard} expected
 */
export function troubleOf({ board, mirrored }, expected) {
  if (mirrored) return "mirrored";
  return isSameBoard(board, { ...expected, legacy: !expected.legacy }) ? "legacy" : "wrong_board";
}
