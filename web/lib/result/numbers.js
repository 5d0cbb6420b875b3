// Numbers of a calibration as people read them. Pure.
import { axialMatrix } from "../../sdk/pinhole.js";
import { COEFFICIENTS, isKnownModel, lensOf } from "../../sdk/projection.js";

/**
 * @typedef {import("../../sdk/calibdb.js").CalibrationData} Calibration
 *
 * @typedef {object} ReportView
 * @property {number} index of the pose it answered
 * @property {number} rms px
 * @property {(number | null)[][]} points px
 * @property {(number | null)[][]} residuals measured minus predicted, px
 * @property {number[]} rvec @property {number[]} tvec pose of the board: board → camera, squares
 * @property {number[]} cut numbers of the points left out of the fit
 * @property {string | null} reason why all of it was left out
 *
 * @typedef {object} Report how a calibration came out, as the service described it then
 * @property {{level: "good" | "fair" | "poor", reasons: {code: string, text: string}[]}} verdict
 * @property {{inflation: number | null, cause: string | null, text: string | null, model?: string | null}} [systematic]
 *   probable cause of systematic errors, and what to do about it; not there if the service was older
 * @property {{fx: number | null, fy: number | null, cx: number | null, cy: number | null, distortion: (number |
 *   null)[]}} std
 * @property {{grid: [number, number], px: (number | null)[][]}} error_map columns and rows; predicted error, px
 * @property {number | null} held_out px rms
 * @property {BoardShape | null} [board] shape that was taken into account
 * @property {ReportView[]} views
 *
 * @typedef {object} BoardShape shares of the board's length, with their standard deviations
 * @property {number} sag @property {number} sag_std
 * @property {number} stretch @property {number} stretch_std
 * @property {"wider" | "narrower" | "skewed" | null} [stretch_kind] older ones have none
 *
 * @typedef {object} Row
 * @property {string} name
 * @property {number} value
 * @property {number | null} std standard deviation
 * @property {number} digits after the point
 * @property {"px" | ""} unit
 *
 * @typedef {object} Result a result as a page shows it
 * @property {Calibration} calibration
 * @property {Report | null} report null: not there, or not yet
 * @property {HTMLCanvasElement | null} [picture] one of this camera, which stays on this device
 * @property {"added" | "imported" | "practice" | "stored"} origin what becomes of it
 * @property {boolean} [ownCameraOffered] the page itself offers to calibrate a real camera after practice
 * @property {string | null} [returnTo] address of the application that asked
 * @property {readonly string[]} [returnOrigins] to which results may be handed
 * @property {boolean} [pending] the report is on its way
 * @property {{code: string, text: string}[]} [notes] what else is to be said
 * @property {{label: () => string, action: () => void}} [again]
 * @property {(without: number[]) => void} [goOn] with the views that are left, by whom they were taken; indices
 * @property {(index: number) => string} [names] of the photographs that views come from, "" where there is none
 * @property {(index: number) => string | null} [photo] address of the picture that a view comes from, which stays on
 *   this device
 * @property {(() => void) | null} [turnOff] ends the picture, which is that of the open camera
 * @property {HTMLElement} [aside] what the page adds below the card: consent, or advice
 * @property {(error: unknown) => string} explain an error, in words for people
 */

// px at an image width of 1280, as in the solver's `quality.assessment`
const MAX_GOOD_PX = 1;
const MAX_FAIR_PX = 3;
const MAX_FAIR_INSIDE_PX = 1; // inside the part of the picture that the board has shown
const MIN_FAIR_COVERED = 0.1; // share of the picture that this part must be
const MAX_RMS_RATIO = 2.5; // times the median rms of the views
const MIN_COSINE = 0.2; // of the angle to the axis: beyond 78° a plane picture is all edge
const MIN_NOTABLE_RMS_PX = 0.3; // px; a smaller rms needs no reason

/**
 * Quality in one word, where no report has it.
 * @param {Calibration} calibration
 * @returns {"good" | "fair" | "poor"}
 */
export function levelOf({ uncertainty: { rms, inside = null, covered = null }, img_size: [width] }) {
  const at1280 = (/** @type {number} */ px) => (px * 1280) / width;
  if (at1280(rms) <= MAX_GOOD_PX) return "good";
  const isFairInside = inside !== null && at1280(inside) <= MAX_FAIR_INSIDE_PX && (covered ?? 0) >= MIN_FAIR_COVERED;
  return at1280(rms) <= MAX_FAIR_PX || isFairInside ? "fair" : "poor";
}

/** True if a fair calibration is fair only where the board has been. @param {Calibration} calibration */
export const isFairInside = ({ uncertainty: { rms, inside }, img_size: [width] }) =>
  typeof inside === "number" && (rms * 1280) / width > MAX_FAIR_PX;

/** Digits after the point that a value with this standard deviation carries. @param {number} std */
export function digitsFor(std) {
  return std > 0 ? Math.min(8, Math.max(0, 1 - Math.floor(Math.log10(std)))) : 2;
}

const COEFFICIENT_DIGITS = 5; // digits of a coefficient

/**
 * Digits after the point of a coefficient without a standard deviation: at least two significant ones.
 * @param {number} value
 */
export const digitsOf = (value) =>
  value === 0
    ? COEFFICIENT_DIGITS
    : Math.min(8, Math.max(COEFFICIENT_DIGITS, 1 - Math.floor(Math.log10(Math.abs(value)))));

/**
 * Focal lengths, centre, coefficients.
 * @param {Calibration} calibration
 * @param {Report | null} report
 * @returns {Row[]}
 */
export function intrinsics(
  { camera_matrix: [[fx, , cx], [, fy, cy]], distortion_coefficients, distortion_model },
  report,
) {
  const names = COEFFICIENTS[distortion_model] ?? [];
  /**
   * @param {string} name
   * @param {number} value
   * @param {number | null | undefined} std
   * @param {number} digits
   * @param {"px" | ""} unit
   * @returns {Row}
   */
  const row = (name, value, std, digits, unit) => ({
    name,
    value,
    std: std ?? null,
    digits: std ? digitsFor(std) : digits,
    unit,
  });
  const std = report?.std;
  return [
    row("fx", fx, std?.fx, 2, "px"),
    row("fy", fy, std?.fy, 2, "px"),
    row("cx", cx, std?.cx, 2, "px"),
    row("cy", cy, std?.cy, 2, "px"),
    ...distortion_coefficients.map((value, index) =>
      row(names[index] ?? `d${index}`, value, std?.distortion[index], digitsOf(value), ""),
    ),
  ];
}

/**
 * Opening angles across the picture's middle and from corner to corner, degrees; null where the model sees no ray
 * there, or where this page does not know the model.
 * @param {Calibration} calibration
 */
export function fieldOfView(calibration) {
  const {
    camera_matrix: [[, , cx], [, , cy]],
    img_size: [width, height],
  } = calibration;
  if (!isKnownModel(calibration.distortion_model)) return { horizontal: null, vertical: null, diagonal: null };
  const lens = lensOf(calibration);
  const between = (/** @type {[number, number]} */ a, /** @type {[number, number]} */ b) => {
    const [p, q] = [lens.unproject(a), lens.unproject(b)];
    if (!p || !q) return null;
    // Through the axis: two rays beyond 90° are more than 180° apart.
    return ((Math.acos(p[2]) + Math.acos(q[2])) * 180) / Math.PI;
  };
  const [right, bottom] = [width - 0.5, height - 0.5];
  return {
    horizontal: between([-0.5, cy], [right, cy]),
    vertical: between([cx, -0.5], [cx, bottom]),
    diagonal: between([-0.5, -0.5], [right, bottom]),
  };
}

/**
 * Displacement by distortion over the image: where the lens shows a ray, and where a pinhole of the same focal length
 * at the axis would. Rays that no plane picture can show are left out.
 * @param {Calibration} calibration @param {[number, number]} grid columns and rows
 * @returns {{from: [number, number], to: [number, number]}[]} px; from: the pinhole's
 */
export function displacements(calibration, [columns, rows]) {
  const {
    img_size: [width, height],
  } = calibration;
  const lens = lensOf(calibration);
  const [[fx, , cx], [, fy, cy]] = axialMatrix(calibration);
  return Array.from({ length: columns * rows }, (_, index) => {
    const [column, row] = [index % columns, Math.floor(index / columns)];
    /** @type {[number, number]} */
    const to = [((column + 0.5) * width) / columns - 0.5, ((row + 0.5) * height) / rows - 0.5];
    return { to, ray: lens.unproject(to) };
  }).flatMap(({ to, ray }) =>
    !ray || ray[2] < MIN_COSINE ? [] : [{ to, from: [(fx * ray[0]) / ray[2] + cx, (fy * ray[1]) / ray[2] + cy] }],
  );
}

/**
 * Distortion along the line from the principal point to the picture's farthest corner, as far as a pinhole shows it.
 * @param {Calibration} calibration of a model that is known here @param {number} steps
 * @returns {{radius: number, shift: number}[]} px from the principal point; shift: outwards, against a pinhole
 */
export function lensProfile(calibration, steps) {
  const {
    camera_matrix: [[, , cx], [, , cy]],
    img_size: [width, height],
  } = calibration;
  const lens = lensOf(calibration);
  const [[fx, , px], [, fy, py]] = axialMatrix(calibration);
  const corner = [cx < width / 2 ? width - 0.5 : -0.5, cy < height / 2 ? height - 0.5 : -0.5];
  const [dx, dy] = [corner[0] - cx, corner[1] - cy];
  const profile = [];
  for (let step = 0; step <= steps; step++) {
    const share = step / steps;
    const ray = lens.unproject([cx + share * dx, cy + share * dy]);
    if (!ray || ray[2] < MIN_COSINE) break;
    const radius = share * Math.hypot(dx, dy);
    const straight = Math.hypot((fx * ray[0]) / ray[2] + px - cx, (fy * ray[1]) / ray[2] + py - cy);
    profile.push({ radius, shift: radius - straight });
  }
  return profile;
}

/**
 * Share of the picture, in cells of a 12th of its width, that has seen corners.
 * @param {number[][]} points
 * @param {[number, number]} size
 */
export function coverage(points, [width, height]) {
  const columns = 12;
  const rows = Math.max(1, Math.round((columns * height) / width));
  const cell = (/** @type {number} */ value, /** @type {number} */ side, /** @type {number} */ count) =>
    Math.min(count - 1, Math.max(0, Math.floor(((value + 0.5) / side) * count)));
  return (
    new Set(points.map(([x, y]) => cell(y, height, rows) * columns + cell(x, width, columns))).size / (columns * rows)
  );
}

/**
 * Remedy for a view: null where none is needed.
 * @param {ReportView} view @param {ReportView[]} views
 * @returns {"left_out" | "stands_out" | "some_cut" | null}
 */
export function viewIssue(view, views) {
  if (view.reason) return "left_out";
  const sorted = views.map(({ rms }) => rms).sort((a, b) => a - b);
  const median = sorted[Math.floor(sorted.length / 2)];
  if (views.length > 2 && view.rms > MAX_RMS_RATIO * median && view.rms > MIN_NOTABLE_RMS_PX) return "stands_out";
  return view.cut.length > 0.1 * view.points.length ? "some_cut" : null;
}

/** @param {Calibration} calibration @param {string} [ending] @returns {string} a file name without spaces */
export function fileName({ camera, img_size }, ending = "json") {
  const name =
    camera
      .toLowerCase()
      .replace(/[^a-z0-9]+/g, "-")
      .replace(/^-|-$/g, "") || "camera";
  return `${name}-${img_size.join("x")}.${ending}`;
}
