// Ring of the calibrations that a camera needs.
import { make } from "../lib/svg.js";

const RING = 7; // units: radius
const GAP = 0.12; // of a part of the ring that is left out between two

/**
 * Ring with a part for each calibration that is needed.
 * @param {{agreeing: number, required: number}} size
 */
export function ring({ agreeing, required }) {
  const parts = Array.from({ length: required }, (_, index) =>
    make("circle", {
      cx: 10,
      cy: 10,
      r: RING,
      pathLength: required,
      class: index < agreeing ? "there" : "",
      "stroke-dasharray": `${1 - GAP} ${required - 1 + GAP}`,
      "stroke-dashoffset": String(required / 4 - index - GAP / 2),
    }),
  );
  return make("svg", { viewBox: "0 0 20 20", class: "ring", "aria-hidden": "true" }, parts);
}
