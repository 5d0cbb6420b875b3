// The network as people meet it: there, or not.

/** The service could not be reached. */
export class OfflineError extends Error {
  constructor() {
    super("calibDB cannot be reached. Check the connection and try again.");
    this.name = "OfflineError";
  }
}

/**
 * `fetch`, whose rejections a person can read. It rejects with a TypeError when there is no network.
 * @param {Parameters<typeof globalThis.fetch>} request
 * @returns {Promise<Response>} rejects with OfflineError
 */
export async function reach(...request) {
  try {
    return await globalThis.fetch(...request);
  } catch (error) {
    if (error instanceof TypeError) throw new OfflineError();
    throw error;
  }
}
