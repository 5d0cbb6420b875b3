// Settings of the pages, `/config.json`: address of the API and the pages' token.
import { OfflineError, reach } from "./network.js";
import { keepItem, readJson } from "./storage.js";

/**
 * @typedef {{api: string, token: string, return_origins?: string[], operator?: {name?: string, contact?: string,
 *   imprint?: string}}} Settings return_origins: origins to which the pages may hand results
 */

const STORAGE_KEY = "calibdb.settings";

/** The page has loaded, but its settings have not. */
export class SettingsError extends Error {}

/**
 * @param {{timeout?: number}} [options] timeout: ms
 * @returns {Promise<Settings>} rejects with OfflineError or SettingsError
 */
export async function loadSettings(options) {
  const response = await reach(new URL("../config.json", import.meta.url), options);
  if (!response.ok) throw new SettingsError(`The page's settings are missing (${response.status}). Try again later.`);
  const settings = await response.json();
  keepItem(STORAGE_KEY, JSON.stringify(settings));
  return settings;
}

/**
 * Settings of the page; without a network those of the last visit.
 * @param {{timeout?: number}} [options] as of `loadSettings`
 * @returns {Promise<Settings>} rejects as `loadSettings`, with OfflineError only at the first visit
 */
export async function lastSettings(options) {
  try {
    return await loadSettings(options);
  } catch (error) {
    const last = error instanceof OfflineError ? storedSettings() : null;
    if (!last) throw error;
    return last;
  }
}

/** Options for calls of the SDK: where the service is, and the pages' token. */
export async function sdkOptions() {
  const { api, token } = await loadSettings();
  return { token, api: new URL(api, location.href) };
}

/** Settings of the last visit, for use without a network. @returns {Settings | null} */
export const storedSettings = () => readJson(STORAGE_KEY);
