// Tokens kept in this browser: the list `calibdb.tokens`, which the documentation's pages read, too.

/**
 * @typedef {object} KeptToken
 * @property {string} id
 * @property {string} token API token
 * @property {string} [management_token] without it, nothing can be changed from here
 * @property {string | null} [name]
 * @property {string[]} origins
 * @property {string} [api] address of the API that gave it
 *
 * @typedef {Pick<Storage, "getItem" | "setItem">} Place
 */

export const STORAGE_KEY = "calibdb.tokens";
const DAMAGED_KEY = "calibdb.tokens.damaged";
const MAX_FILE_TOKENS = 1000;
const [TOKEN, MANAGEMENT] = [
  /^cdb_([A-Za-z0-9-]{1,64})_[A-Za-z0-9_-]{1,128}$/,
  /^cdbm_([A-Za-z0-9-]{1,64})_[A-Za-z0-9_-]{1,128}$/,
];

/** The file holds no tokens, or not those of this service. */
export class TokenFileError extends Error {
  /** @param {"unreadable" | "empty" | "elsewhere"} code @param {string} [detail] */
  constructor(code, detail = "") {
    super(code);
    this.code = code;
    this.detail = detail;
  }
}

/** List of tokens in a storage; where the browser keeps nothing, in memory until the page is left. */
export class KeptTokens {
  /** @type {KeptToken[]} */
  #memory = [];
  #place;

  /** @param {Place | null} place */
  constructor(place) {
    this.#place = place;
  }

  /** Those that are kept; another tab may have changed them. @returns {KeptToken[]} */
  get all() {
    const text = this.#read();
    if (text === null) return this.#memory;
    try {
      return tokensOf(JSON.parse(text));
    } catch (error) {
      if (!(error instanceof SyntaxError)) throw error;
      // What cannot be read is set aside, never written over: it may hold the only copy of a secret.
      this.#write(DAMAGED_KEY, text);
      this.#write(STORAGE_KEY, "[]");
      return [];
    }
  }

  /**
   * Keeps a token, over the one with its id.
   * @param {KeptToken} token
   * @returns {boolean} whether it outlasts the page
   */
  keep(token) {
    const all = this.all;
    const at = all.findIndex(({ id }) => id === token.id);
    return this.#store(at < 0 ? [token, ...all] : all.with(at, { ...all[at], ...token }));
  }

  /** @param {string} id */
  forget(id) {
    return this.#store(this.all.filter((token) => token.id !== id));
  }

  /** @param {KeptToken[]} tokens */
  #store(tokens) {
    this.#memory = tokens;
    return this.#write(STORAGE_KEY, JSON.stringify(tokens));
  }

  /** Null where nothing was kept, or nothing can be. */
  #read() {
    try {
      return this.#place?.getItem(STORAGE_KEY) ?? null;
    } catch (error) {
      if (!(error instanceof DOMException)) throw error;
      return null;
    }
  }

  /** @param {string} name @param {string} text */
  #write(name, text) {
    try {
      this.#place?.setItem(name, text);
      return this.#place !== null && this.#place.getItem(name) === text;
    } catch (error) {
      if (!(error instanceof DOMException)) throw error; // full, or not allowed
      this.#place = null;
      return false;
    }
  }
}

/** The browser's storage; null where it gives none. @returns {Storage | null} */
export function browserStorage() {
  try {
    return globalThis.localStorage ?? null;
  } catch (error) {
    if (!(error instanceof DOMException)) throw error;
    return null;
  }
}

/** Text of a file with tokens. @param {KeptToken[]} tokens */
export const fileOf = (tokens) => `${JSON.stringify(tokens, null, 2)}\n`;

/**
 * The tokens in such a file. Those of other services stay out: a secret is sent to none but the one that gave it.
 * @param {string} text @param {string} api address of this API
 * @returns {{tokens: KeptToken[], elsewhere: number}} elsewhere: how many were left out; throws TokenFileError
 */
export function tokensInFile(text, api) {
  let content;
  try {
    content = JSON.parse(text);
  } catch (error) {
    if (!(error instanceof SyntaxError)) throw error;
    throw new TokenFileError("unreadable");
  }
  const found = tokensOf(content).slice(0, MAX_FILE_TOKENS);
  if (found.length === 0) throw new TokenFileError("empty");
  const tokens = found.filter((token) => !token.api || sameApi(token.api, api));
  const other = found.find((token) => token.api && !sameApi(token.api, api));
  if (tokens.length === 0) throw new TokenFileError("elsewhere", other?.api ?? "");
  return { tokens, elsewhere: found.length - tokens.length };
}

/** @param {string} one @param {string} other */
const sameApi = (one, other) => URL.canParse(one) && new URL(one).href === new URL(other).href;

/** Tokens that a document lists; whatever else it holds stays out. @param {any} content @returns {KeptToken[]} */
function tokensOf(content) {
  const list = Array.isArray(content) ? content : [content];
  return list.flatMap((each) => {
    const id = TOKEN.exec(each?.token)?.[1];
    if (!id) return [];
    const { token, management_token: management, name, origins, api } = each;
    return [
      {
        id,
        token,
        ...(MANAGEMENT.exec(management)?.[1] === id && { management_token: management }),
        name: typeof name === "string" ? name : null,
        origins: Array.isArray(origins) ? origins.filter((origin) => typeof origin === "string") : [],
        ...(typeof api === "string" && { api }),
      },
    ];
  });
}
