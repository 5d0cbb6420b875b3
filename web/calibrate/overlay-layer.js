// Overlay on the video: the target and its preview, the detected corners, the arrows. Elements are reused: making a hundred
// for each frame would cost more than detecting the board.
import { blackSquares } from "../lib/target-preview.js";
import { arrows } from "./hint-arrows.js";
import { viewCount } from "./state.js";
import { unmirrored } from "./status-text.js";

/** @typedef {import("./state.js").State} State */
/** @typedef {import("./parts.js").Parts} Parts */

const SVG = "http://www.w3.org/2000/svg";
const GONE_AT = 0.5; // overlap with the target from which its squares are not drawn
const LATER_VISIBILITY = 0.6; // once a view was taken, everybody knows what a target is
const [MIN_FILL, MAX_FILL] = [0.04, 0.16]; // opacity of the target's area

/** @param {Parts} parts @param {State} state @param {State | null} before */
export function renderTarget({ overlay, target, targetBack, targetCorner, ghost }, state, before) {
  const { capture: { pose }, ui: { picture } } = state;
  if (picture !== before?.ui.picture) {
    overlay.hidden = !picture;
    if (picture) overlay.src = picture;
  }
  if (pose === before?.capture.pose) return;
  const outline = polygon(pose?.outline ?? []);
  target.setAttribute("points", outline);
  targetBack.setAttribute("points", outline);
  ghost.setAttribute("d", pose ? blackSquares(state.board, pose).map((square) => `M${polygon(square)}Z`).join("") : "");
  // A dot shows which way up: at the board's first corner, where the printed board has marker 0.
  const [x, y] = pose?.outline[0] ?? [-99, -99];
  targetCorner.setAttribute("cx", String(x));
  targetCorner.setAttribute("cy", String(y));
}

/**
 * Fades the target as the board gets there: where the two lie over each other, only the outline tells them apart.
 * @param {Parts} parts @param {State} state @param {State | null} before
 */
function fadeTarget({ overlay, target, ghost }, state, before) {
  const shown = visibility(state);
  if (before && before.phase === "capturing" && shown === visibility(before)) return;
  overlay.style.opacity = ghost.style.opacity = String(shown);
  overlay.style.visibility = shown > 0 ? "" : "hidden";
  target.style.fillOpacity = String(MIN_FILL + (MAX_FILL - MIN_FILL) * shown);
}

/** Share of the target's squares that is shown, 0…1 in steps that are not worth more drawing. @param {State} state */
export function visibility(state) {
  const most = viewCount(state) === 0 ? 1 : LATER_VISIBILITY;
  return Math.round(most * Math.max(0, 1 - state.detector.overlap / GONE_AT) * 20) / 20;
}

/** @param {Parts} parts @param {State} state @param {State | null} before */
export function renderDetection(parts, state, before) {
  const { corners, arrows: group, seenOutline } = parts;
  fadeTarget(parts, state, before);
  const { detector, ui, capture: { aim, key } } = state;
  if (detector.corners === before?.detector.corners && ui.instruction === before?.ui.instruction) return;
  drawCircles(corners, detector.corners.points);
  seenOutline.setAttribute("points", polygon(detector.outline ?? []));
  drawLines(group, arrows(unmirrored(state), detector.outline, aim, key?.img_size[0] ?? 1280));
}

/** @param {SVGElement} group @param {number[][]} points */
function drawCircles(group, points) {
  resize(group, "circle", points.length, { class: "corner", r: "5" });
  points.forEach(([x, y], index) => {
    group.children[index].setAttribute("cx", x.toFixed(1));
    group.children[index].setAttribute("cy", y.toFixed(1));
  });
}

/** @param {SVGElement} group @param {import("./hint-arrows.js").Arrow[]} ways */
function drawLines(group, ways) {
  resize(group, "line", ways.length, { "marker-end": "url(#arrowhead)" });
  ways.forEach((way, index) => {
    ["x1", "y1", "x2", "y2"].forEach((name, at) => group.children[index].setAttribute(name, way[at].toFixed(1)));
  });
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

/** @param {number[][]} points */
const polygon = (points) => points.map(([x, y]) => `${x.toFixed(1)},${y.toFixed(1)}`).join(" ");
