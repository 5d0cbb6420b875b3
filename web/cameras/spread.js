// Spread of the calibrations of one camera that agree: what its consensus is sure of. Pure.

/** @typedef {import("./agreement.js").Member} Member */

/**
 * Standard deviations between calibrations by one model; distortion coefficients are not compared: they trade off.
 * @param {Member[]} members @param {string} model
 * @returns {{count: number, fx: number, fy: number, cx: number, cy: number, distortion: (number | null)[]} | null} px;
 *   null: fewer than two
 */
export function spreadOf(members, model) {
  const agreeing = members.filter((member) => member.in_group && member.model === model);
  if (agreeing.length < 2) return null;
  const deviation = (/** @type {"fx" | "fy" | "cx" | "cy"} */ name) => {
    const mean = agreeing.reduce((sum, member) => sum + member[name], 0) / agreeing.length;
    return Math.sqrt(agreeing.reduce((sum, member) => sum + (member[name] - mean) ** 2, 0) / (agreeing.length - 1));
  };
  return {
    count: agreeing.length,
    fx: deviation("fx"),
    fy: deviation("fy"),
    cx: deviation("cx"),
    cy: deviation("cy"),
    distortion: [],
  };
}
