// File output: hands files to the browser, which saves them.

const KEPT_MS = 60_000; // by then the browser has read the file

/** @param {Blob} content @param {string} name */
export function offerFile(content, name) {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(content), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), KEPT_MS);
}

/**
 * Hands the file of a response to the browser. It is read completely before it is offered, so that a broken transfer is
 * an error, not half a file.
 * @param {Response} response @param {string} otherwise name of a file that the service has not named
 * @returns {Promise<string>} its name
 */
export async function offerResponse(response, otherwise) {
  const [, named] = /filename="?([^";]+)"?/.exec(response.headers.get("content-disposition") ?? "") ?? [];
  const name = named ?? otherwise;
  offerFile(await response.blob(), name);
  return name;
}
