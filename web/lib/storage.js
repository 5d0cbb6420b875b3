// Items that pages keep in this browser. A browser that blocks storage throws on access: then nothing is kept.

/** @param {string} name @returns {string | null} */
export function readItem(name) {
  try {
    return globalThis.localStorage?.getItem(name) ?? null;
  } catch (error) {
    if (!(error instanceof DOMException)) throw error;
    return null;
  }
}

/** @param {string} name @returns {any} null: there is none, or it is damaged */
export function readJson(name) {
  try {
    return JSON.parse(readItem(name) ?? "null");
  } catch (error) {
    if (!(error instanceof SyntaxError)) throw error;
    return null;
  }
}

/** @param {string} name @param {string | null} text null: forgets it @returns {boolean} false: it is not kept */
export function keepItem(name, text) {
  try {
    if (text === null) globalThis.localStorage?.removeItem(name);
    else globalThis.localStorage?.setItem(name, text);
    return true;
  } catch (error) {
    if (!(error instanceof DOMException)) throw error;
    return false;
  }
}
