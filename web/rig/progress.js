// Progress of a rig: which cameras still lack what. Pure.

/** @import { RigState } from "./service.js" */

/**
 * @typedef {{rms: number | null, atTarget: boolean}} Stage of a capture, after one of its moments: the error stated
 *   then, px, and whether the board was at its target
 */

export const MIN_VIEWS = 4; // of each camera
const MAX_MOMENTS = 20; // with which a capture ends at the accuracy reached so far
// A plateau of the error, as in calibsolver.capture.ending, where views are counted instead of moments:
const MIN_PLATEAU_MOMENTS = 10;
const PLATEAU_SPAN = 3; // moments over which the error is compared
const MIN_PROGRESS = 0.85; // smallest error / that of PLATEAU_SPAN moments earlier: above it there is no progress
const MAX_ABOVE_BEST = 1.3; // error / the smallest so far, with which a capture ends
const IDLE_MS = 30_000; // without another moment, after which a capture ends if it can
const MAX_MISSED = 2; // moments in a row that a camera has not answered, before it is waited for

/**
 * Positions of the cameras of other devices that have joined.
 * @param {RigState} state
 * @param {readonly number[]} own positions of this device
 */
export const remotePositions = ({ cameras }, own) =>
  cameras
    .filter(({ position, status }) => status !== "waiting" && !own.includes(position))
    .map(({ position }) => position);

/** Positions that no device has taken yet. @param {RigState} state */
export const freePositions = ({ cameras }) =>
  cameras.filter(({ status }) => status === "waiting").map(({ position }) => position);

/** True if one camera alone has joined so far. @param {RigState} state */
export const isAlone = (state) => state.cameras.length - freePositions(state).length < 2;

/** True if there is enough for a result. @param {RigState} state */
export const isFinishable = ({ status, cameras, unlinked, rms }) =>
  status === "capturing" && rms !== null && unlinked.length === 0 && cameras.every(({ views }) => views >= MIN_VIEWS);

/**
 * True if the error has stopped falling although the board is held at its targets.
 * @param {readonly Stage[]} course one for each moment
 */
export function hasPlateau(course) {
  /** @type {number[]} */
  const smallest = [];
  for (const { rms } of course.slice(MIN_VIEWS - 1))
    smallest.push(Math.min(smallest.at(-1) ?? Infinity, rms ?? Infinity));
  const [last, best] = [course.at(-1)?.rms ?? null, smallest.at(-1) ?? Infinity];
  return (
    course.length >= MIN_PLATEAU_MOMENTS &&
    last !== null &&
    last <= MAX_ABOVE_BEST * best &&
    best > MIN_PROGRESS * smallest[smallest.length - 1 - PLATEAU_SPAN] &&
    course.slice(-PLATEAU_SPAN).every(({ atTarget }) => atTarget)
  );
}

/**
 * True if the capture ends without a click: it is accurate, or more moments would hardly help, or none come any more.
 * @param {RigState} state
 * @param {number} idle ms since the last moment
 * @param {readonly Stage[]} course one for each moment
 */
export function isComplete(state, idle, course) {
  const isAccurate = state.uncertainty !== null && state.uncertainty.rms <= state.target_error;
  return (
    isFinishable(state) && (isAccurate || hasPlateau(course) || state.moments.length >= MAX_MOMENTS || idle > IDLE_MS)
  );
}

/**
 * Positions of other devices that have answered none of the last moments: they may hold views that they cannot deliver.
 * @param {RigState} state @param {readonly number[]} own positions of this device
 */
export function silentPositions(state, own) {
  const last = state.moments.slice(-MAX_MISSED);
  if (last.length < MAX_MISSED) return [];
  return remotePositions(state, own).filter((position) => !last.some(({ positions }) => positions.includes(position)));
}
