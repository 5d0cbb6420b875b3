// Picture of a regular grid as a lens shows it: what there is to straighten where no photograph is at hand.
import { axialMatrix } from "../../sdk/pinhole.js";
import { lensOf } from "../../sdk/projection.js";
import { el } from "../dom.js";

/** @typedef {import("../../sdk/projection.js").Intrinsics & {img_size: [number, number]}} Calibration */

const SQUARES = 18; // across what the lens sees
const MAX_TANGENT = 2.5; // of the angle to the axis, 68°: beyond it a plane grid is all edge
const STEPS = 6; // of a line, a square

/**
 * Half the width and height of the plane at distance 1 that the picture shows.
 * @param {ReturnType<typeof lensOf>} lens @param {[number, number]} size px
 */
function reach(lens, [width, height]) {
  const border = Array.from({ length: 33 }, (_, index) => index / 32).flatMap(
    (share) =>
      /** @type {[number, number][]} */ ([
        [share * (width - 1), 0],
        [share * (width - 1), height - 1],
        [0, share * (height - 1)],
        [width - 1, share * (height - 1)],
      ]),
  );
  const rays = border.map((point) => lens.unproject(point)).filter((ray) => ray !== null && ray[2] > 0.1);
  return [0, 1].map((axis) =>
    Math.min(MAX_TANGENT, Math.max(0.05, ...rays.map((ray) => Math.abs((ray?.[axis] ?? 0) / (ray?.[2] ?? 1))))),
  );
}

/**
 * Lines of a plane grid in the picture, broken where the lens sees none of them.
 * @param {Calibration} calibration of a model that is known here
 * @returns {{seen: [number, number][], ideal: [number, number][]}[]} px, points along each: as the lens shows them,
 *   and as a pinhole of its focal length at the axis would
 */
export function gridLines(calibration) {
  const lens = lensOf(calibration);
  const [x, y] = reach(lens, calibration.img_size);
  const step = (2 * x) / SQUARES;
  const whole = (/** @type {number} */ length) => Math.ceil(length / step) * step;
  const [right, bottom] = [whole(x), whole(y)];
  const [[fx, , cx], [, fy, cy]] = axialMatrix(calibration);
  const along = (/** @type {number} */ end, /** @type {number} */ by) =>
    Array.from({ length: Math.round((2 * end) / by) + 1 }, (_, index) => index * by - end);
  const lines = [
    ...along(right, step).map((u) => along(bottom, step / STEPS).map((v) => [u, v])),
    ...along(bottom, step).map((v) => along(right, step / STEPS).map((u) => [u, v])),
  ];
  return lines.flatMap((line) => {
    /** @type {ReturnType<typeof gridLines>} */
    const parts = [{ seen: [], ideal: [] }];
    for (const [u, v] of line) {
      const part = parts[parts.length - 1];
      const point = lens.project([u, v, 1]);
      if (!point) {
        if (part.seen.length) parts.push({ seen: [], ideal: [] });
        continue;
      }
      part.seen.push(point);
      part.ideal.push([fx * u + cx, fy * v + cy]);
    }
    return parts.filter(({ seen }) => seen.length > 1);
  });
}

/** @param {Calibration} calibration small enough to draw @returns {HTMLCanvasElement} */
export function gridPicture(calibration) {
  const {
    img_size: [width, height],
  } = calibration;
  const canvas = el("canvas", { width, height });
  const context = canvas.getContext("2d");
  if (!context) return canvas;
  context.fillStyle = "#f6f7f5";
  context.fillRect(0, 0, width, height);
  context.strokeStyle = "#14181a";
  context.lineWidth = Math.max(1, width / 500);
  context.lineJoin = "round";
  for (const { seen } of gridLines(calibration)) {
    context.beginPath();
    for (const [u, v] of seen) context.lineTo(u + 0.5, v + 0.5);
    context.stroke();
  }
  return canvas;
}
