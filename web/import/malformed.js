// A file that cannot be used, and why, in a word that the page has a sentence for.

export class MalformedError extends Error {
  /** @param {string} code of a sentence: "import.wrong_…" @param {Record<string, string | number>} [values] in it */
  constructor(code, values = {}) {
    super([code, ...Object.entries(values).map(([name, value]) => `${name}=${value}`)].join(" "));
    this.name = "MalformedError";
    this.code = code;
    this.values = values;
  }
}
