// Values of a calibration as they are written: with as many digits as they are worth, small ones with a power of ten;
// as code, and as JSON.
import { number } from "../i18n.js";

const MAX_DIGITS = 10; // of what a program takes: far more than any calibration is worth
const MIN_PLAIN = 1e-3; // below this a number has a power of ten
const SUPERSCRIPT = ["⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"];

/** @param {number} exponent */
const power = (exponent) => {
  const digits = [...String(Math.abs(exponent))].map((digit) => SUPERSCRIPT[Number(digit)]).join("");
  return `\u00a0×\u00a010${exponent < 0 ? "⁻" : ""}${digits}`;
};

/**
 * A number and its standard deviation, both to the same place.
 * @param {number} value @param {number | null} std @param {number} digits after the point @param {"px" | ""} unit
 * @returns {{value: string, std: string}} with units; std: "" where there is none
 */
export function valueText(value, std, digits, unit) {
  const after = unit ? `\u00a0${unit}` : "";
  const size = Math.max(Math.abs(value), std ?? 0);
  if (unit || value === 0 || size >= MIN_PLAIN) {
    return { value: number(value, digits) + after, std: std ? `±\u00a0${number(std, digits)}${after}` : "" };
  }
  const exponent = Math.floor(Math.log10(size));
  const places = Math.max(1, Math.min(digits, 8) + exponent);
  const scaled = (/** @type {number} */ each) => number(each / 10 ** exponent, places) + power(exponent);
  return { value: scaled(value), std: std ? `±\u00a0${scaled(std)}` : "" };
}

/**
 * Camera matrix and coefficients as a program takes them.
 * @param {import("./numbers.js").Calibration} calibration @param {"numpy" | "json"} form
 * @returns {{K: string, D: string}}
 */
export function matrixText({ camera_matrix: rows, distortion_coefficients: coefficients }, form) {
  const line = (/** @type {readonly number[]} */ values) =>
    `[${values.map((value) => Number(value.toPrecision(MAX_DIGITS))).join(", ")}]`;
  if (form === "json") return { K: `[${rows.map(line).join(", ")}]`, D: line(coefficients) };
  return { K: `K = np.array([${rows.map(line).join(",\n              ")}])`, D: `D = np.array(${line(coefficients)})` };
}

/**
 * JSON as people read it: a list of numbers or words on one line, everything else on lines of its own.
 * @param {unknown} value @returns {string} ends without a line break
 */
export function jsonText(value, indent = "") {
  const inner = `${indent}  `;
  if (Array.isArray(value)) {
    if (value.every((each) => each === null || typeof each !== "object"))
      return `[${value.map((each) => JSON.stringify(each)).join(", ")}]`;
    return `[\n${value.map((each) => inner + jsonText(each, inner)).join(",\n")}\n${indent}]`;
  }
  if (value !== null && typeof value === "object") {
    const members = Object.entries(value).filter(([, each]) => each !== undefined);
    const lines = members.map(([name, each]) => `${inner}${JSON.stringify(name)}: ${jsonText(each, inner)}`);
    return lines.length ? `{\n${lines.join(",\n")}\n${indent}}` : "{}";
  }
  return JSON.stringify(value);
}
