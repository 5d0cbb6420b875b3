// Lattice of a chessboard's corners among the saddle points of an image. Pure.
import { describe, hasRing, responseAt } from "./saddle-points.js";

/**
 * @import { Saddle } from "./saddle-points.js"
 * @import { Grey } from "./subpixel.js"
 */

/**
 * @typedef {object} Lattice
 * @property {number} columns of corners
 * @property {number} rows
 * @property {([number, number] | null)[]} points row by row, px; null: not seen. x to the right, y down as the board is
 *   seen, or turned
 * @property {boolean} firstIsBlack whether the square between the first four corners is black
 */

const NEAREST = 12; // points that may be a neighbour
const MAX_AXIS_DIFFERENCE = (40 * Math.PI) / 180; // rad, from the quarter turn between neighbouring corners
const MIN_SECTOR = (40 * Math.PI) / 180; // rad between neighbours
const EDGE_PLACES = [0.25, 0.4, 0.5, 0.6, 0.75]; // of the way from corner to corner
const EDGE_OFFSET = 0.08; // of that way, to either side of the edge
const MIN_SIDE_CONTRAST = 0.25; // of the corners' own
const MAX_CORNER_MISS = 0.2; // of the distance of neighbours, between a predicted corner and a point
// of the neighbour's: the edge of a board, where no two black squares meet, has less than none
const MIN_FAINT_RESPONSE = 0.15;
const MIN_CORNERS_A_SIDE = 2;
const MIN_LINE_SHARE = 0.5; // of the corners of a row or column at the edge of the lattice

/**
 * The largest lattice in an image.
 * @param {Grey} image @param {Saddle[]} saddles
 * @returns {Lattice | null}
 */
export function findLattice(image, saddles) {
  const edges = connect(image, saddles);
  const seen = new Set();
  /** @type {Map<string, Saddle>} */
  let largest = new Map();
  for (let start = 0; start < saddles.length; start++) {
    if (seen.has(start) || edges[start].length < 2) continue;
    const placed = label(saddles, edges, start, seen);
    if (placed.size > largest.size) largest = placed;
    if (largest.size > saddles.length - seen.size) break; // no remaining lattice can be larger
  }
  if (largest.size < 2 * MIN_CORNERS_A_SIDE) return null;
  grow(image, saddles, largest);
  return rectangle(image, largest);
}

/** @param {number} angle rad @param {number} period */
const wrapped = (angle, period) => Math.abs(angle - period * Math.round(angle / period));

/**
 * Neighbours of each point: an edge of alternating colours leads to them.
 * @param {Grey} image
 * @param {Saddle[]} saddles
 * @returns {number[][]}
 */
function connect(image, saddles) {
  const near = nearest(saddles);
  const chosen = saddles.map((from, index) => {
    /** @type {{to: number, angle: number}[]} */
    const taken = [];
    for (const to of near(index)) {
      const other = saddles[to];
      if (wrapped(from.axis + Math.PI / 2 - other.axis, Math.PI) > MAX_AXIS_DIFFERENCE) continue;
      const angle = Math.atan2(other.y - from.y, other.x - from.x);
      if (taken.some((each) => wrapped(each.angle - angle, 2 * Math.PI) < MIN_SECTOR)) continue;
      if (!isEdge(image, from, other)) continue;
      taken.push({ to, angle });
      if (taken.length === 4) break;
    }
    return taken.map(({ to }) => to);
  });
  return chosen.map((list, from) => list.filter((to) => chosen[to].includes(from)));
}

/** @param {Saddle[]} saddles @returns {(index: number) => number[]} the nearest points, nearest first */
function nearest(saddles) {
  const xs = saddles.map(({ x }) => x);
  const span = Math.max(...xs, 1) - Math.min(...xs, 0) + 1;
  const side = Math.max(8, Math.sqrt((span * span) / Math.max(1, saddles.length)));
  /** @type {Map<string, number[]>} */
  const cells = new Map();
  const cell = (/** @type {number} */ value) => Math.floor(value / side);
  saddles.forEach(({ x, y }, index) => {
    const key = `${cell(x)},${cell(y)}`;
    const list = cells.get(key);
    if (list) list.push(index);
    else cells.set(key, [index]);
  });
  return (index) => {
    const { x, y } = saddles[index];
    /** @type {{to: number, distance: number}[]} */
    let found = [];
    for (let reach = 1; reach <= 16; reach *= 2) {
      found = [];
      for (let j = -reach; j <= reach; j++) {
        for (let i = -reach; i <= reach; i++) {
          for (const to of cells.get(`${cell(x) + i},${cell(y) + j}`) ?? []) {
            if (to !== index) found.push({ to, distance: Math.hypot(saddles[to].x - x, saddles[to].y - y) });
          }
        }
      }
      if (found.filter(({ distance }) => distance <= reach * side).length >= NEAREST) break;
    }
    return found
      .sort((a, b) => a.distance - b.distance)
      .slice(0, NEAREST)
      .map(({ to }) => to);
  };
}

/**
 * True if one side of the way is dark all along, and the other bright.
 * @param {Grey} image
 * @param {Saddle} from
 * @param {Saddle} to
 */
function isEdge(image, from, to) {
  const [dx, dy] = [to.x - from.x, to.y - from.y];
  const length = Math.hypot(dx, dy);
  const offset = Math.max(2, EDGE_OFFSET * length);
  const [nx, ny] = [(-dy / length) * offset, (dx / length) * offset];
  const least = MIN_SIDE_CONTRAST * Math.min(from.contrast, to.contrast);
  let sign = 0;
  for (const place of EDGE_PLACES) {
    const [x, y] = [from.x + place * dx, from.y + place * dy];
    const difference = sample(image, x + nx, y + ny) - sample(image, x - nx, y - ny);
    if (Math.abs(difference) < least || difference * sign < 0) return false;
    sign = difference;
  }
  return true;
}

/** @param {Grey} image @param {number} x @param {number} y px; the nearest pixel of the image */
function sample({ width, height, data }, x, y) {
  const [column, row] = [Math.round(x), Math.round(y)];
  return data[Math.min(height - 1, Math.max(0, row)) * width + Math.min(width - 1, Math.max(0, column))];
}

/**
 * Columns and rows of all points that edges lead to.
 * @param {Saddle[]} saddles
 * @param {number[][]} edges
 * @param {number} start
 * @param {Set<number>} seen points of any lattice; added to
 * @returns {Map<string, Saddle>} by "column,row"
 */
function label(saddles, edges, start, seen) {
  const [first] = edges[start];
  const towards = (/** @type {number} */ a, /** @type {number} */ b) => [
    saddles[b].x - saddles[a].x,
    saddles[b].y - saddles[a].y,
  ];
  const u = towards(start, first);
  const across = edges[start]
    .map((to) => towards(start, to))
    .find(([x, y]) => Math.abs(u[0] * y - u[1] * x) > 0.6 * Math.hypot(...u) * Math.hypot(x, y));
  const v = across ? (u[0] * across[1] - u[1] * across[0] > 0 ? across : [-across[0], -across[1]]) : [-u[1], u[0]];
  /** @type {Map<string, Saddle>} */
  const placed = new Map([["0,0", saddles[start]]]);
  const queue = [{ index: start, i: 0, j: 0, u, v }];
  seen.add(start);
  for (let step = queue.shift(); step; step = queue.shift()) {
    const axes = step;
    const determinant = axes.u[0] * axes.v[1] - axes.u[1] * axes.v[0];
    for (const to of edges[step.index]) {
      if (seen.has(to)) continue;
      const d = towards(step.index, to);
      const [a, b] = [
        (d[0] * axes.v[1] - d[1] * axes.v[0]) / determinant,
        (axes.u[0] * d[1] - axes.u[1] * d[0]) / determinant,
      ];
      const [alongU, alongV] = [Math.abs(a) > 0.6 && Math.abs(b) < 0.45, Math.abs(b) > 0.6 && Math.abs(a) < 0.45];
      if (alongU === alongV) continue;
      const [i, j] = alongU ? [step.i + Math.sign(a), step.j] : [step.i, step.j + Math.sign(b)];
      const key = `${i},${j}`;
      if (placed.has(key)) continue;
      placed.set(key, saddles[to]);
      seen.add(to);
      const along = alongU ? d.map((value) => value * Math.sign(a)) : d.map((value) => value * Math.sign(b));
      queue.push({ index: to, i, j, u: alongU ? along : axes.u, v: alongU ? axes.v : along });
    }
  }
  return placed;
}

/**
 * Adds the corners that the ones found so far lead to.
 * @param {Grey} image
 * @param {Saddle[]} saddles
 * @param {Map<string, Saddle>} placed
 */
function grow(image, saddles, placed) {
  const used = new Set(placed.values());
  const tried = new Set();
  for (let more = true; more;) {
    more = false;
    for (const key of [...placed.keys()]) {
      const [i, j] = key.split(",").map(Number);
      for (const [di, dj] of [
        [1, 0],
        [-1, 0],
        [0, 1],
        [0, -1],
      ]) {
        const there = `${i + di},${j + dj}`;
        const [here, before, behind] = [
          placed.get(key),
          placed.get(`${i - di},${j - dj}`),
          placed.get(`${i - 2 * di},${j - 2 * dj}`),
        ];
        const attempt = `${there} ${key} ${Boolean(behind)}`;
        if (placed.has(there) || !here || !before || tried.has(attempt)) continue;
        tried.add(attempt);
        // Straight on, with the change of the distance where it is known: a homography to second order.
        const bend = (/** @type {"x" | "y"} */ axis) => (behind ? here[axis] - 2 * before[axis] + behind[axis] : 0);
        const [x, y] = [2 * here.x - before.x + bend("x"), 2 * here.y - before.y + bend("y")];
        const reach = MAX_CORNER_MISS * Math.hypot(here.x - before.x, here.y - before.y);
        const found = closest(saddles, x, y, reach, used) ?? faint(image, x, y, here);
        if (
          !found ||
          wrapped(here.axis + Math.PI / 2 - found.axis, Math.PI) > MAX_AXIS_DIFFERENCE ||
          !isEdge(image, here, found)
        )
          continue;
        placed.set(there, found);
        used.add(found);
        more = true;
      }
    }
  }
}

/**
 * @param {Saddle[]} saddles
 * @param {number} x
 * @param {number} y
 * @param {number} reach px
 * @param {Set<Saddle>} used
 * @returns {Saddle | null}
 */
function closest(saddles, x, y, reach, used) {
  let [best, least] = [/** @type {Saddle | null} */ (null), reach];
  for (const saddle of saddles) {
    const distance = Math.hypot(saddle.x - x, saddle.y - y);
    if (distance < least && !used.has(saddle)) [best, least] = [saddle, distance];
  }
  return best;
}

/**
 * A corner that is too faint to be found unless its place is predicted.
 * @param {Grey} image
 * @param {number} x
 * @param {number} y
 * @param {Saddle} next
 * @returns {Saddle | null}
 */
function faint(image, x, y, next) {
  const [column, row] = [Math.round(x), Math.round(y)];
  if (!hasRing(image, column, row)) return null;
  const strength = responseAt(image, column, row);
  return strength > MIN_FAINT_RESPONSE * next.strength ? { ...describe(image, strength, column, row), x, y } : null;
}

/** @param {Grey} image @param {Map<string, Saddle>} placed @returns {Lattice | null} */
function rectangle(image, placed) {
  const keys = [...placed.keys()].map((key) => key.split(",").map(Number));
  let [left, right] = [Math.min(...keys.map(([i]) => i)), Math.max(...keys.map(([i]) => i))];
  let [top, bottom] = [Math.min(...keys.map(([, j]) => j)), Math.max(...keys.map(([, j]) => j))];
  const share = (/** @type {(i: number, j: number) => boolean} */ holds) => {
    const inside = keys.filter(([i, j]) => i >= left && i <= right && j >= top && j <= bottom && holds(i, j)).length;
    return inside;
  };
  // A line at the edge with few corners is not part of the board: something next to the board looked like corners.
  for (let trimmed = true; trimmed && left < right && top < bottom;) {
    const [across, down] = [(right - left + 1) * MIN_LINE_SHARE, (bottom - top + 1) * MIN_LINE_SHARE];
    trimmed = true;
    if (share((i) => i === left) < down) left += 1;
    else if (share((i) => i === right) < down) right -= 1;
    else if (share((_, j) => j === top) < across) top += 1;
    else if (share((_, j) => j === bottom) < across) bottom -= 1;
    else trimmed = false;
  }
  const [columns, rows] = [right - left + 1, bottom - top + 1];
  if (columns < MIN_CORNERS_A_SIDE || rows < MIN_CORNERS_A_SIDE) return null;
  /** @type {([number, number] | null)[]} */
  const points = [];
  for (let j = top; j <= bottom; j++) {
    for (let i = left; i <= right; i++) {
      const saddle = placed.get(`${i},${j}`);
      points.push(saddle ? [saddle.x, saddle.y] : null);
    }
  }
  return { columns, rows, points, firstIsBlack: firstIsBlack(image, columns, rows, points) };
}

/**
 * By the vote of all squares.
 * @param {Grey} image
 * @param {number} columns
 * @param {number} rows
 * @param {([number, number] | null)[]} points
 */
function firstIsBlack(image, columns, rows, points) {
  /** @type {{even: boolean, value: number}[]} */
  const cells = [];
  for (let j = 0; j + 1 < rows; j++) {
    for (let i = 0; i + 1 < columns; i++) {
      const [a, b, c, d] = [0, 1, columns, columns + 1].map((offset) => points[j * columns + i + offset]);
      if (a && b && c && d)
        cells.push({
          even: (i + j) % 2 === 0,
          value: sample(image, (a[0] + b[0] + c[0] + d[0]) / 4, (a[1] + b[1] + c[1] + d[1]) / 4),
        });
    }
  }
  const mean = (/** @type {boolean} */ even) => {
    const values = cells.filter((cell) => cell.even === even).map(({ value }) => value);
    return values.reduce((sum, value) => sum + value, 0) / Math.max(1, values.length);
  };
  return mean(true) < mean(false);
}
