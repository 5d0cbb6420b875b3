// What is drawn over the video: the target, its ghost, the corners seen, the arrows. Kept elements are moved: making a
// hundred a frame would cost more than finding the board.
import { arrows } from "./hint-arrows.js";
import { blackSquares } from "../lib/target-preview.js";
import { unmirrored } from "./status-text.js";

/** @typedef {import("./state.js").State} State */
/** @typedef {import("./render.js").Parts} Parts */

const SVG = "http://www.w3.org/2000/svg";

/** @param {Parts} parts @param {State} state @param {State | null} before */
export function renderTarget({ overlay, target, targetBack, targetCorner, ghost }, state, before) {
  if (state.picture !== before?.picture) {
    overlay.hidden = !state.picture;
    if (state.picture) overlay.src = state.picture;
  }
  if (state.pose === before?.pose) return;
  const outline = polygon(state.pose?.outline ?? []);
  target.setAttribute("points", outline);
  targetBack.setAttribute("points", outline);
  ghost.setAttribute("d", state.pose ? blackSquares(state.board, state.pose).map((square) => `M${polygon(square)}Z`).join("") : "");
  // Which way up: the board's first corner has a dot, on the target as on the printed board's marker 0.
  const [x, y] = state.pose?.outline[0] ?? [-99, -99];
  targetCorner.setAttribute("cx", String(x));
  targetCorner.setAttribute("cy", String(y));
}

/** @param {Parts} parts @param {State} state @param {State | null} before */
export function renderSeen({ corners, arrows: group, seenOutline }, state, before) {
  if (state.corners === before?.corners && state.instruction === before?.instruction) return;
  circles(corners, state.corners.points);
  seenOutline.setAttribute("points", polygon(state.outline ?? []));
  const width = state.key?.img_size[0] ?? 1280;
  lines(group, arrows(unmirrored(state), state.outline, state.aim, width));
}

/** @param {SVGElement} group @param {number[][]} points */
function circles(group, points) {
  keep(group, "circle", points.length, { class: "corner", r: "5" });
  points.forEach(([x, y], index) => {
    group.children[index].setAttribute("cx", x.toFixed(1));
    group.children[index].setAttribute("cy", y.toFixed(1));
  });
}

/** @param {SVGElement} group @param {import("./hint-arrows.js").Arrow[]} ways */
function lines(group, ways) {
  keep(group, "line", ways.length, { "marker-end": "url(#arrowhead)" });
  ways.forEach((way, index) => {
    ["x1", "y1", "x2", "y2"].forEach((name, at) => group.children[index].setAttribute(name, way[at].toFixed(1)));
  });
}

/** @param {SVGElement} group @param {string} name @param {number} count @param {Record<string, string>} attributes */
function keep(group, name, count, attributes) {
  while (group.children.length < count) {
    const made = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    group.append(made);
  }
  while (group.children.length > count) group.lastElementChild?.remove();
}

/** @param {number[][]} points */
const polygon = (points) => points.map(([x, y]) => `${x.toFixed(1)},${y.toFixed(1)}`).join(" ");
