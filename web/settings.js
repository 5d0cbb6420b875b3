// Where the API is, and the token of these pages: written by whoever serves them.
import { reach } from "./network.js";

/** @typedef {{api: string, token: string, return_origins?: string[]}} Settings return_origins: to which results may be handed */

/** The page is there and what belongs to it is not. */
export class SettingsError extends Error {}

/** @returns {Promise<Settings>} rejects with OfflineError or SettingsError */
export async function loadSettings() {
  const response = await reach(new URL("./config.json", import.meta.url));
  if (!response.ok) throw new SettingsError(`The page's settings are missing (${response.status}). Try again later.`);
  return response.json();
}
