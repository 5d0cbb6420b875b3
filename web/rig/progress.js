// Progress of a rig: which cameras still lack what. Pure.

/** @typedef {import("./service.js").RigState} RigState */

export const MIN_VIEWS = 4; // of each camera
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

/** Whether the accuracy that was asked for is reached. @param {RigState} state */
export const isAccurate = (state) =>
  isFinishable(state) && state.uncertainty !== null && state.uncertainty.rms <= state.target_error;

/**
 * Positions of other devices that have answered none of the last moments: they may hold views that they cannot deliver.
 * @param {RigState} state @param {readonly number[]} own positions of this device
 */
export function silentPositions(state, own) {
  const last = state.moments.slice(-MAX_MISSED);
  if (last.length < MAX_MISSED) return [];
  return remotePositions(state, own).filter((position) => !last.some(({ positions }) => positions.includes(position)));
}
