// Marks on a camera's picture: the target with its preview, the corners that were detected. Elements are reused:
// making a hundred for each frame would cost more than detecting the board.
import { isBlack } from "../board.js";

/** @import { Board } from "../board.js" */

/**
 * @typedef {number[][]} Polygon
 */

const SVG = "http://www.w3.org/2000/svg";

/**
 * @param {{target: SVGElement, targetBack: SVGElement, targetCorner: SVGElement, ghost: SVGElement}} parts
 * @param {Board} board
 * @param {{ids: number[], corners: number[][], outline: number[][]} | null} pose px; null: no target
 */
export function drawTarget({ target, targetBack, targetCorner, ghost }, board, pose) {
  const outline = polygon(pose?.outline ?? []);
  target.setAttribute("points", outline);
  targetBack.setAttribute("points", outline);
  ghost.setAttribute(
    "d",
    pose
      ? blackSquares(board, pose)
          .map((square) => `M${polygon(square)}Z`)
          .join("")
      : "",
  );
  // A dot shows which way up: at the board's first corner, where the printed board has marker 0.
  const [x, y] = pose?.outline[0] ?? [-99, -99];
  targetCorner.setAttribute("cx", String(x));
  targetCorner.setAttribute("cy", String(y));
}

const GONE_AT = 0.5; // overlap with the target from which its squares are not drawn

/**
 * Share of the target's squares that is shown, 0…1: where both overlap, only the outline distinguishes them.
 * @param {number} overlap of the board with the target, Jaccard index
 */
export const visibleShare = (overlap) => Math.max(0, 1 - overlap / GONE_AT);

/**
 * The board as it is seen: its corners and its outline.
 * @param {{corners: SVGElement, seenOutline: SVGElement}} parts @param {import("./sight.js").Sight} sight
 */
export function drawBoard({ corners, seenOutline }, sight) {
  const { points } = sight.corners;
  resize(corners, "circle", points.length, { class: "corner", r: "5" });
  points.forEach(([x, y], index) => {
    write(corners.children[index], "cx", x.toFixed(1));
    write(corners.children[index], "cy", y.toFixed(1));
  });
  seenOutline.setAttribute("points", polygon(sight.outline ?? []));
}

/** @param {SVGElement} group @param {number[][]} ways x and y of both ends, px */
export function drawArrows(group, ways) {
  resize(group, "line", ways.length, { "marker-end": "url(#arrowhead)" });
  ways.forEach((way, index) => {
    ["x1", "y1", "x2", "y2"].forEach((name, at) => write(group.children[index], name, way[at].toFixed(1)));
  });
}

/**
 * Writes changes alone: what stays is not drawn again.
 * @param {Element} element
 * @param {string} name
 * @param {string} value
 */
function write(element, name, value) {
  if (element.getAttribute(name) !== value) element.setAttribute(name, value);
}

/** @param {SVGElement} group @param {string} name @param {number} count @param {Record<string, string>} attributes */
function resize(group, name, count, attributes) {
  while (group.children.length < count) {
    const made = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    group.append(made);
  }
  while (group.children.length > count) group.lastElementChild?.remove();
}

/** Points of an SVG polygon. @param {number[][]} points */
export const polygon = (points) => points.map(([x, y]) => `${x.toFixed(1)},${y.toFixed(1)}`).join(" ");

/**
 * Black squares of the board in a pose, or its tags, seen through the same lens as its corners. The inner vertices are
 * the service's and exact; those at the board's edge are extrapolated from the two before them.
 * @param {Board} board @param {{ids: number[], corners: number[][]}} pose
 * @returns {Polygon[]} px
 */
export function blackSquares(board, { ids, corners }) {
  const [columns, rows] = board.squares;
  if (board.kind === "aprilgrid") return tags(columns * rows, new Map(ids.map((id, index) => [id, corners[index]])));
  const vertex = vertexOf(board, { ids, corners });
  /** @type {Polygon[]} */
  const squares = [];
  for (let y = 0; y < rows; y++) {
    for (let x = 0; x < columns; x++) {
      if (!isBlack(board, x, y)) continue;
      const vertices = [vertex(x, y), vertex(x + 1, y), vertex(x + 1, y + 1), vertex(x, y + 1)];
      if (vertices.every((each) => each !== null)) squares.push(/** @type {Polygon} */ (vertices));
    }
  }
  return squares;
}

/**
 * Places of a board's vertices, its rim included.
 * @param {Board} board no AprilGrid @param {{ids: number[], corners: number[][]}} pose
 * @returns {(x: number, y: number) => number[] | null} by column and row, squares; null where too few corners are known
 */
export function vertexOf({ squares: [columns, rows] }, { ids, corners }) {
  const place = new Map(ids.map((id, index) => [id, corners[index]]));
  /** @type {(x: number, y: number) => number[] | null} */
  const vertex = (x, y) => {
    if (x === 0) return extrapolate(vertex(1, y), vertex(2, y));
    if (x === columns) return extrapolate(vertex(columns - 1, y), vertex(columns - 2, y));
    if (y === 0) return extrapolate(vertex(x, 1), vertex(x, 2));
    if (y === rows) return extrapolate(vertex(x, rows - 1), vertex(x, rows - 2));
    return place.get((y - 1) * (columns - 1) + x - 1) ?? null;
  };
  return vertex;
}

/** @param {number} count @param {Map<number, number[]>} place of corners by their ids @returns {Polygon[]} px */
function tags(count, place) {
  const polygons = Array.from({ length: count }, (_, tag) => [0, 1, 2, 3].map((corner) => place.get(4 * tag + corner)));
  return /** @type {Polygon[]} */ (polygons.filter((polygon) => polygon.every((vertex) => vertex !== undefined)));
}

/** @param {number[] | null} near @param {number[] | null} next */
const extrapolate = (near, next) => (near && next ? [2 * near[0] - next[0], 2 * near[1] - next[1]] : null);
