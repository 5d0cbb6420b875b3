// Progress of a rig: which cameras still lack what. Pure.

/** @typedef {import("./service.js").RigState} RigState */

export const MIN_VIEWS = 4; // of each camera
const MAX_MOMENTS = 20; // with which a capture ends at the accuracy reached so far
const IDLE_MS = 30_000; // without another moment, after which a capture ends if it can
const MAX_MISSED = 2; // moments in a row that a camera has not answered, before it is waited for

/** Positions of the cameras of other devices that have joined. @param {RigState} state @param {readonly number[]} own positions of this device */
export const remotePositions = ({ cameras }, own) =>
  cameras.filter(({ position, status }) => status !== "waiting" && !own.includes(position)).map(({ position }) => position);

/** Positions that no device has taken yet. @param {RigState} state */
export const freePositions = ({ cameras }) => cameras.filter(({ status }) => status === "waiting").map(({ position }) => position);

/** Whether one camera alone has joined so far. @param {RigState} state */
export const isAlone = (state) => state.cameras.length - freePositions(state).length < 2;

/** Whether there is enough for a result. @param {RigState} state */
export const isFinishable = ({ status, cameras, unlinked, rms }) =>
  status === "capturing" && rms !== null && unlinked.length === 0 && cameras.every(({ views }) => views >= MIN_VIEWS);

/**
 * True if the capture ends without a click: it is accurate, or more moments would hardly help, or none come any more.
 * @param {RigState} state @param {number} idle ms since the last moment
 */
export function isComplete(state, idle) {
  const isAccurate = state.uncertainty !== null && state.uncertainty.rms <= state.target_error;
  return isFinishable(state) && (isAccurate || state.moments.length >= MAX_MOMENTS || idle > IDLE_MS);
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
