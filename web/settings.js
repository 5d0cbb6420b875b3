// Where the API is, and the token of these pages: written by whoever serves them.

/** @typedef {{api: string, token: string}} Settings */

/** @returns {Promise<Settings>} */
export async function loadSettings() {
  const response = await fetch(new URL("./config.json", import.meta.url));
  if (!response.ok) throw new Error(`The page's settings are missing (${response.status}).`);
  return response.json();
}
