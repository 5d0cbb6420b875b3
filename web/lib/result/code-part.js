// Part of a result with the code that uses it: in Python, and in a web page.
import { addCopyButton } from "../code-block.js";
import { el } from "../dom.js";
import { matrixText } from "./values.js";

/** @import { Calibration } from "./numbers.js" */

/**
 * @typedef {[name: string, label: string, code: string]} Block
 */

/** Calls of OpenCV that straighten a picture, by model. @type {Record<string, string>} */
const STRAIGHTEN = {
  rectilinear: "straight = cv2.undistort(image, K, D)",
  rational: "straight = cv2.undistort(image, K, D)",
  fisheye: "straight = cv2.fisheye.undistortImage(image, K, D, Knew=K)",
  omnidirectional: `xi, D = D[:1], D[1:]
straight = cv2.omnidir.undistortImage(image, K, D, xi, cv2.omnidir.RECTIFY_PERSPECTIVE, Knew=K)`,
};

/** @param {Calibration} calibration */
function python(calibration) {
  const { K, D } = matrixText(calibration, "numpy");
  const call = STRAIGHTEN[calibration.distortion_model];
  return `import cv2\nimport numpy as np\n\n${K}\n${D}\n${call ? `\n${call}\n` : ""}`;
}

/** @param {string} id */
const javascript = (id) => `const response = await fetch(
  "${location.origin}/v1/calibrations/${encodeURIComponent(id)}",
  { headers: { authorization: "Bearer cdb_…" } }, // your token
);
const { camera_matrix, distortion_coefficients } = await response.json();
`;

/** @param {Calibration} calibration @param {string | null} id where it is stored */
export const codePart = (calibration, id) =>
  codeBlocks([
    ["python", "Python", python(calibration)],
    ...(id ? /** @type {Block[]} */ ([["javascript", "JavaScript", javascript(id)]]) : []),
  ]);

/** Code to copy, each under its heading. @param {Block[]} blocks */
export function codeBlocks(blocks) {
  return el(
    "div",
    { class: "codes" },
    ...blocks.map(([name, label, code]) =>
      el(
        "div",
        {},
        el("h3", { id: `code-${name}` }, label),
        addCopyButton(el("pre", { tabindex: 0, "aria-labelledby": `code-${name}` }, el("code", {}, code))),
      ),
    ),
  );
}
