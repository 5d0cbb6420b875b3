// Error for a file that cannot be used; its code names a message.

export class MalformedError extends Error {
  /** @param {string} code of a sentence: "import.wrong_…" @param {Record<string, string | number>} [values] in it */
  constructor(code, values = {}) {
    super([code, ...Object.entries(values).map(([name, value]) => `${name}=${value}`)].join(" "));
    this.name = "MalformedError";
    this.code = code;
    this.values = values;
  }
}
