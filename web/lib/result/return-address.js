// Return address: the application that sent somebody here to calibrate a camera.

/**
 * Address to hand a result to: the address that was asked for, if its origin is this site's own, HTTPS, or of the
 * visitor's own machine, or one that the operator of the service allows. Pages never redirect there: they offer a link
 * that names the host, and the link carries nothing but the id of a published calibration.
 * @param {string | null} wanted from this page's own address @param {string} here this page's origin
 * @param {readonly string[]} allowed origins
 * @returns {{url: URL, allowed: boolean} | null} null: nobody asked, or it is no address of a web page
 */
export function returnAddress(wanted, here, allowed) {
  if (!wanted || !URL.canParse(wanted, here)) return null;
  const url = new URL(wanted, here);
  if (!/^https?:$/.test(url.protocol) || url.username || url.password) return null;
  const secure = url.protocol === "https:" || /^(localhost|127\.0\.0\.1|\[::1\])$/.test(url.hostname);
  return { url, allowed: url.origin === here || secure || allowed.includes(url.origin) };
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
