// An address as a QR code.
import { encode } from "../vendor/uqr/uqr.js";

const QUIET = 4; // modules of white around it, as ISO/IEC 18004 asks

/** @param {string} address @returns {{size: number, path: string}} side in modules; the black ones as an SVG path */
function qrPath(address) {
  const { data, size } = encode(address, { ecc: "M", border: QUIET });
  const path = data.flatMap((row, y) => row.flatMap((black, x) => (black ? [`M${x} ${y}h1v1h-1z`] : []))).join("");
  return { size, path };
}

/** @param {SVGElement} svg @param {string} address */
export function drawQr(svg, address) {
  const { size, path } = qrPath(address);
  svg.setAttribute("viewBox", `0 0 ${size} ${size}`);
  svg.setAttribute("shape-rendering", "crispEdges");
  const modules = svg.ownerDocument.createElementNS("http://www.w3.org/2000/svg", "path");
  modules.setAttribute("d", path);
  svg.replaceChildren(modules);
}
