// What the page says about itself, by its state.

/** @typedef {import("./state.js").State} State */

/** @param {number} count */
const views = (count) => `${count} ${count === 1 ? "view" : "views"}`;

/** What is being waited for before a capture. @param {State} state */
export function opening({ waiting, patience, loading }) {
  if (patience > 0) return "The connection to calibDB is lost. Trying again.";
  if (waiting === "camera") return "Waiting for the camera. If your browser asks, allow it.";
  if (waiting === "service") return "Asking calibDB for a session.";
  return loading < 1 ? "Loading the board detector, 12 MB the first time." : "Starting the board detector.";
}

/** @param {State} state */
export function kept({ session }) {
  const count = session?.views.length ?? 0;
  if (count === 0) return "";
  return `${views(count)} ${count === 1 ? "is" : "are"} kept. Try again with the same camera to go on.`;
}

/** @param {State} state */
export function stopping({ stopAsked, session }) {
  return stopAsked === null ? "Stop" : `Stop and lose ${views(session?.views.length ?? 0)}?`;
}

/** @param {State} state */
export function counts({ session }) {
  const accuracy = session?.uncertainty ? ` · ± ${session.uncertainty.rms.toFixed(2)} px` : "";
  return `${views(session?.views.length ?? 0)}${accuracy}`;
}
