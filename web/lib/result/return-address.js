// Return address: the application that sent the visitor here to calibrate a camera.

const LOOPBACK = /^(localhost|127\.0\.0\.1|\[::1\])$/;

/** True if an address is of the visitor's own machine. @param {URL} url */
export const isLoopback = ({ hostname }) => LOOPBACK.test(hostname);

/**
 * @typedef {object} ReturnAddress
 * @property {URL} url
 * @property {string} host
 * @property {boolean} isHere a page of this site
 * @property {boolean} allowed results may be handed there
 */

/**
 * Address to hand a result to: the address that was asked for, if its origin is this site's own, HTTPS, or of the
 * visitor's own machine, or one that the operator of the service allows. Pages never redirect there: they offer a link
 * that names the host, and the link carries nothing but the id of a published calibration.
 * @param {string | null} wanted from this page's own address @param {string} here this page's origin
 * @param {readonly string[]} allowed origins
 * @returns {ReturnAddress | null} null: the address of the page names none, or none of a web page
 */
export function returnAddress(wanted, here, allowed) {
  if (!wanted || !URL.canParse(wanted, here)) return null;
  const url = new URL(wanted, here);
  if (!/^https?:$/.test(url.protocol) || url.username || url.password) return null;
  const secure = url.protocol === "https:" || isLoopback(url);
  const isHere = url.origin === here;
  return { url, host: url.host, isHere, allowed: isHere || secure || allowed.includes(url.origin) };
}

/**
 * The address with the result: in the fragment, which no server gets to see but the application's own page.
 * @param {URL} url @param {string} id of the calibration
 */
export function withResult(url, id) {
  const there = new URL(url);
  const fragment = new URLSearchParams(there.hash.slice(1));
  fragment.set("calibration", id);
  there.hash = fragment.toString();
  return there.href;
}
