// Where the API is, and the token of these pages: written by whoever serves them.
import { reach } from "./network.js";

/** @typedef {{api: string, token: string, return_origins?: string[]}} Settings return_origins: to which results may be handed */

const KEPT = "calibdb.settings";

/** The page is there and what belongs to it is not. */
export class SettingsError extends Error {}

/** @param {{patience?: number}} [options] patience: ms @returns {Promise<Settings>} rejects with OfflineError or SettingsError */
export async function loadSettings(options) {
  const response = await reach(new URL("../config.json", import.meta.url), options);
  if (!response.ok) throw new SettingsError(`The page's settings are missing (${response.status}). Try again later.`);
  const settings = await response.json();
  keep(settings);
  return settings;
}

/** Those of the last visit, for who goes on without a network. @returns {Settings | null} */
export function keptSettings() {
  try {
    return JSON.parse(localStorage.getItem(KEPT) ?? "null");
  } catch (error) {
    if (!(error instanceof DOMException) && !(error instanceof SyntaxError)) throw error;
    return null;
  }
}

/** @param {Settings} settings */
function keep(settings) {
  try {
    localStorage.setItem(KEPT, JSON.stringify(settings));
  } catch (error) {
    if (!(error instanceof DOMException)) throw error; // not kept, then
  }
}
