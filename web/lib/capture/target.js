// Distance of the board from its target, hints that lead there, and when it is there. Outlines are quadrilaterals in
// pixels: the board's corners, clockwise from its first.

/** @typedef {number[][]} Quadrilateral */

const FAR = 0.2; // of the board's size, between the middles
const LARGER = 1.25; // in length
const TURNED = 0.14; // rad
const TILTED = 0.06; // difference in the logarithm of how much longer one side is than the opposite one

/**
 * The corners as seen, or turned by 180° if that is nearer to the target: an upside-down board is as informative.
 * @param {Quadrilateral} seen
 * @param {Quadrilateral} target
 */
export function upright(seen, target) {
  const turned = [...seen.slice(2), ...seen.slice(0, 2)];
  return spread(turned, target) < spread(seen, target) ? turned : seen;
}

/** @param {Quadrilateral} a @param {Quadrilateral} b */
const spread = (a, b) =>
  a.reduce((sum, [x, y], index) => sum + Math.hypot(x - b[index][0], y - b[index][1]), 0) / a.length;

/**
 * Difference of two poses of the board: mean distance of its corners from the target's, once the middles and the
 * sizes have been made the same (the overlap measures place and size), as a share of the board's size.
 *
 * A hand that misses by 3° is below 0.07; a board that faces the camera in a target tilted by 35° or more is above
 * 0.085.
 * @param {Quadrilateral} seen @param {Quadrilateral} target
 */
export function difference(seen, target) {
  const alike = (/** @type {Quadrilateral} */ quadrilateral) => {
    const [[x, y], unit] = [middle(quadrilateral), size(quadrilateral)];
    return quadrilateral.map(([u, v]) => [(u - x) / unit, (v - y) / unit]);
  };
  return spread(alike(upright(seen, target)), alike(target));
}

/**
 * Quantity that is furthest from the target, each in units of a hand's tolerance.
 * @param {Quadrilateral} outline as seen @param {Quadrilateral} target
 * @returns {string} a code, about the camera's picture: left right up down (and two of them: up_left), closer, farther,
 *   turn_clockwise, turn_counterclockwise, tilt_top, tilt_bottom, tilt_left, tilt_right; "" where nothing is left to
 * say
 */
export function advice(outline, target) {
  const seen = upright(outline, target);
  const wanting = [place(seen, target), distance(seen, target), turn(seen, target), tilt(seen, target)];
  const { code, excess } = wanting.reduce((most, each) => (each.excess > most.excess ? each : most));
  return excess > 1 ? code : "";
}

/** @typedef {{code: string, excess: number}} Difference how many times what a hand may miss by */

/** @param {Quadrilateral} seen @param {Quadrilateral} target @returns {Difference} */
function place(seen, target) {
  const [from, to] = [middle(seen), middle(target)];
  const [right, down] = [0, 1].map((axis) => (to[axis] - from[axis]) / size(target));
  const ways = [
    Math.abs(down) > FAR / 2 && (down > 0 ? "down" : "up"),
    Math.abs(right) > FAR / 2 && (right > 0 ? "right" : "left"),
  ];
  return { code: ways.filter(Boolean).join("_"), excess: Math.hypot(right, down) / FAR };
}

/** @param {Quadrilateral} seen @param {Quadrilateral} target @returns {Difference} */
function distance(seen, target) {
  const larger = Math.log(size(target) / size(seen));
  return { code: larger > 0 ? "closer" : "farther", excess: Math.abs(larger) / Math.log(LARGER) };
}

/** @param {Quadrilateral} seen @param {Quadrilateral} target @returns {Difference} */
function turn(seen, target) {
  const angle = Math.atan2(...direction(target)) - Math.atan2(...direction(seen));
  const shortest = Math.atan2(Math.sin(angle), Math.cos(angle));
  return { code: shortest > 0 ? "turn_clockwise" : "turn_counterclockwise", excess: Math.abs(shortest) / TURNED };
}

/**
 * The nearer side of a board looks longer, the more so the larger the board looks: compared as if both looked as large.
 * @param {Quadrilateral} seen @param {Quadrilateral} target @returns {Difference}
 */
function tilt(seen, target) {
  const larger = size(target) / size(seen);
  const ratio = (/** @type {Quadrilateral} */ quadrilateral, /** @type {number} */ side) =>
    Math.log(length(quadrilateral, side) / length(quadrilateral, side + 2));
  const [first, second] = [0, 1].map((side) => ratio(target, side) - larger * ratio(seen, side));
  const side = Math.abs(first) > Math.abs(second) ? (first > 0 ? 0 : 2) : second > 0 ? 1 : 3;
  const [a, b] = [target[side], target[(side + 1) % 4]];
  const [cx, cy] = middle(target);
  const [x, y] = [(a[0] + b[0]) / 2 - cx, (a[1] + b[1]) / 2 - cy];
  const name = Math.abs(x) > Math.abs(y) ? (x < 0 ? "left" : "right") : y < 0 ? "top" : "bottom";
  return { code: `tilt_${name}`, excess: Math.max(Math.abs(first), Math.abs(second)) / TILTED };
}

/** @param {Quadrilateral} quadrilateral */
export const middle = (quadrilateral) =>
  [0, 1].map((axis) => quadrilateral.reduce((sum, point) => sum + point[axis], 0) / 4);

/** Square root of the area, px. @param {Quadrilateral} quadrilateral */
function size(quadrilateral) {
  const doubled = quadrilateral.reduce((sum, [x, y], index) => {
    const [u, v] = quadrilateral[(index + 1) % 4];
    return sum + x * v - u * y;
  }, 0);
  return Math.sqrt(Math.abs(doubled) / 2);
}

/** Along the board's rows, y first. @param {Quadrilateral} quadrilateral @returns {[number, number]} */
function direction([a, b, c, d]) {
  return [b[1] - a[1] + c[1] - d[1], b[0] - a[0] + c[0] - d[0]];
}

/** @param {Quadrilateral} quadrilateral @param {number} side from this corner to the next */
function length(quadrilateral, side) {
  const [[x, y], [u, v]] = [quadrilateral[side % 4], quadrilateral[(side + 1) % 4]];
  return Math.hypot(u - x, v - y);
}

/** @type {Record<string, string>} */
const MIRROR_IMAGE = {
  left: "right",
  right: "left",
  clockwise: "counterclockwise",
  counterclockwise: "clockwise",
};

/**
 * Mirrors the direction in a code: an instruction must agree with the preview, and codes are about the camera's image.
 * @param {string} code
 */
export function asMirrored(code) {
  return code
    .split("_")
    .map((part) => MIRROR_IMAGE[part] ?? part)
    .join("_");
}

/**
 * @typedef {object} Instruction the one that is shown
 * @property {string} code shown now: of a message
 * @property {string} next to be shown
 * @property {number} since ms, when `next` was first chosen
 */

const MIN_CHOSEN_MS = 400; // before a new instruction replaces the one that is shown

/**
 * Instruction that is steady enough to be read.
 * @param {Instruction} before @param {string} next its code @param {number} time ms
 * @param {boolean} [urgent] shown at once
 * @returns {Instruction}
 */
export function settled(before, next, time, urgent = false) {
  const since = next === before.next ? before.since : time;
  const code = before.code === "" || urgent || time - since >= MIN_CHOSEN_MS ? next : before.code;
  return { code, next, since };
}

export const HOLD_MS = 700; // still at the target
export const LONG_HOLD_MS = 1_500; // still anywhere else: the service judges whether the view helps all the same
const LENIENT_AFTER_MS = 3_000; // after which the hand may move more,
const MAX_LENIENCE = 4; // at most so many times the motion of a steady hand

/**
 * Factor on the motion that counts as still: it grows with time, for visitors without a steady hand.
 * @param {number} elapsed ms since the target was set
 */
export const lenienceAfter = (elapsed) => Math.min(MAX_LENIENCE, Math.max(1, elapsed / LENIENT_AFTER_MS));

const OVERLAP_REDUCTION = 4; // |ΔJ| < 0.01 against full size

/**
 * Jaccard index of two areas of the image: |A ∩ B| / |A ∪ B|, counted in pixels of a quarter of the size.
 * @param {number[][]} a polygon, px @param {number[][]} b polygon, px
 * @param {[number, number]} size of the image: what lies outside does not count
 * @returns {number} 0…1; 0 where both are empty
 */
export function jaccard(a, b, [width, height]) {
  const columns = Math.ceil(width / OVERLAP_REDUCTION);
  const rows = Math.ceil(height / OVERLAP_REDUCTION);
  let both = 0;
  let sum = 0;
  const [inA, inB] = [new Float64Array(a.length), new Float64Array(b.length)];
  const heights = [...a, ...b].map((point) => point[1] / OVERLAP_REDUCTION);
  const [top, bottom] = [
    Math.max(0, Math.floor(Math.min(...heights)) - 1),
    Math.min(rows, Math.ceil(Math.max(...heights)) + 1),
  ];
  for (let row = top; row < bottom; row++) {
    const y = (row + 0.5) * OVERLAP_REDUCTION - 0.5;
    const [countA, countB] = [findSpans(a, y, columns, inA), findSpans(b, y, columns, inB)];
    for (let i = 0; i < countA; i += 2) sum += inA[i + 1] - inA[i];
    for (let j = 0; j < countB; j += 2) sum += inB[j + 1] - inB[j];
    for (let i = 0; i < countA; i += 2) {
      for (let j = 0; j < countB; j += 2)
        both += Math.max(0, Math.min(inA[i + 1], inB[j + 1]) - Math.max(inA[i], inB[j]));
    }
  }
  return sum === 0 ? 0 : both / (sum - both);
}

/**
 * The parts of one row inside a polygon, by the even-odd rule.
 * @param {number[][]} polygon @param {number} y px @param {number} columns of the row
 * @param {Float64Array} spans filled: start and end of each part, columns
 * @returns {number} how many numbers were filled in
 */
function findSpans(polygon, y, columns, spans) {
  let count = 0;
  for (let index = 0; index < polygon.length; index++) {
    const from = polygon[index];
    const to = polygon[index + 1 < polygon.length ? index + 1 : 0];
    if (from[1] <= y === to[1] <= y) continue;
    const crossing = from[0] + ((y - from[1]) / (to[1] - from[1])) * (to[0] - from[0]);
    let at = count++;
    for (; at > 0 && spans[at - 1] > crossing; at--) spans[at] = spans[at - 1];
    spans[at] = crossing;
  }
  for (let index = 0; index + 1 < count; index += 2) {
    // Pixel i has its centre at (i + 0.5) * OVERLAP_REDUCTION - 0.5.
    spans[index] = Math.max(0, Math.ceil((spans[index] + 0.5) / OVERLAP_REDUCTION - 0.5));
    spans[index + 1] = Math.max(
      spans[index],
      Math.min(columns, Math.ceil((spans[index + 1] + 0.5) / OVERLAP_REDUCTION - 0.5)),
    );
  }
  return count - (count % 2);
}
