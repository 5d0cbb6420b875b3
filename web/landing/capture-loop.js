// Picture of a guided capture: a board that is led to the amber outline, again and again. Board, poses and lens are those of
// the capture page, drawn small.
import { DEFAULT_BOARD, isBlack, markers, outline } from "../lib/board.js";
import { gridThrough } from "../lib/figure.js";
import { t } from "../lib/i18n.js";
import { interpolatePose, rotationMatrix } from "../lib/pose.js";
import { make } from "../lib/svg.js";
import { lensOf } from "../sdk/projection.js";

/** @typedef {import("../lib/pose.js").Pose} Pose */

/** @type {[number, number]} */
const SIZE = [640, 400];
const LENS = {
  camera_matrix: [[460, 0, 320], [0, 460, 200], [0, 0, 1]], distortion_model: "rectilinear", distortion_coefficients: [-0.22, 0.05, 0, 0, 0],
};
/** Poses that a capture asks for, of a board nine squares wide; in squares. @type {Pose[]} */
const TARGETS = [
  { rvec: [0, 0, 0], tvec: [-4.5, -3, 9] },
  { rvec: [0, 0.6, 0.05], tvec: [-5.6, -3.6, 11] },
  { rvec: [-0.65, 0, 0], tvec: [-1.2, -3.2, 11.5] },
  { rvec: [0.1, -0.65, -0.2], tvec: [-3.4, -1.6, 12.5] },
];
const START = { rvec: [0.2, -0.3, 0.3], tvec: [-6.5, -1.2, 14] };
const MOVE_MS = 1500;
const HOLD_MS = 900;
const STEP_MS = MOVE_MS + HOLD_MS;
const END_MS = 2400; // the verdict stands for so long
const STILL_MS = 0.62 * MOVE_MS; // of who wants no motion: the board on its way, where both can be told apart
const EDGE_PARTS = 4; // of a side that the lens bends

/**
 * Draws the loop in a figure and plays it while it is in sight.
 * @param {SVGElement} svg @param {HTMLElement} words for the instruction @param {HTMLButtonElement} toggle stops and plays it
 */
export function captureLoop(svg, words, toggle) {
  svg.setAttribute("viewBox", `0 0 ${SIZE[0]} ${SIZE[1]}`);
  const world = make("g", { class: "world" }, gridThrough(LENS, SIZE, 40).map((line) => make("path", { d: path([line]) })));
  const [paper, black, tags, target] = ["paper", "black", "tags", "wanted"].map((name) => make("path", { class: name }));
  const ring = make("circle", { class: "held", cx: 46, cy: 46, r: 20, pathLength: 100 });
  svg.replaceChildren(world, paper, black, tags, target, ring);

  const still = matchMedia("(prefers-reduced-motion: reduce)");
  let playing = !still.matches;
  let seen = true;
  let at = still.matches ? STILL_MS : 0;
  let before = 0;

  const draw = () => {
    const { pose, wanted, held, said } = scene(at);
    paper.setAttribute("d", path([ring4(pose, -0.35)]));
    black.setAttribute("d", path(areas(pose, isBlackSquare)));
    tags.setAttribute("d", path(areas(pose, isTag)));
    target.setAttribute("d", wanted ? path([ring4(wanted, 0)]) : "");
    ring.setAttribute("stroke-dasharray", `${100 * held} 100`);
    const text = said();
    if (words.textContent !== text) words.textContent = text;
  };
  const frame = (/** @type {number} */ now) => {
    if (!playing || !seen) return;
    // A frame's time may lie before the call that asked for it.
    at = (at + Math.min(100, Math.max(0, now - before))) % (TARGETS.length * STEP_MS + END_MS);
    before = now;
    draw();
    requestAnimationFrame(frame);
  };
  const go = () => {
    toggle.setAttribute("aria-pressed", String(!playing));
    before = performance.now();
    if (playing && seen) requestAnimationFrame(frame);
  };
  toggle.addEventListener("click", () => {
    playing = !playing;
    go();
  });
  new IntersectionObserver(([{ isIntersecting }]) => {
    if (isIntersecting === seen) return;
    seen = isIntersecting;
    go();
  }).observe(svg);
  draw();
  go();
  return draw;
}

/** @param {number} at ms since the beginning */
function scene(at) {
  const step = Math.min(TARGETS.length - 1, Math.floor(at / STEP_MS));
  const since = at - step * STEP_MS;
  const [from, to] = [step === 0 ? START : TARGETS[step - 1], TARGETS[step]];
  const moved = Math.min(1, since / MOVE_MS);
  const pose = interpolatePose(from, to, moved * moved * (3 - 2 * moved));
  if (at >= TARGETS.length * STEP_MS) return { pose, wanted: null, held: 0, said: () => t("landing.loop_done") };
  const held = Math.max(0, Math.min(1, (since - MOVE_MS) / (HOLD_MS - 200)));
  return { pose, wanted: to, held, said: () => t(moved < 1 ? "landing.loop_follow" : held < 1 ? "landing.loop_hold" : "landing.loop_taken", { count: step + 1 }) };
}

/** @param {number} x @param {number} y */
const isBlackSquare = (x, y) => (isBlack(DEFAULT_BOARD, x, y) ? [x, y, 1] : null);
const tagged = new Set(markers(DEFAULT_BOARD).map(({ x, y }) => `${x},${y}`));
const MARGIN = (1 - DEFAULT_BOARD.marker_ratio) / 2;
/** @param {number} x @param {number} y */
const isTag = (x, y) => (tagged.has(`${x},${y}`) ? [x + MARGIN, y + MARGIN, DEFAULT_BOARD.marker_ratio] : null);

/** @param {Pose} pose @param {(x: number, y: number) => number[] | null} of the square, where there is one */
function areas(pose, of) {
  const [columns, rows] = DEFAULT_BOARD.squares;
  const found = [];
  for (let y = 0; y < rows; y++) {
    for (let x = 0; x < columns; x++) {
      const area = of(x, y);
      if (area) found.push(project(pose, corners(area[0], area[1], area[2], area[2])));
    }
  }
  return found;
}

/** The board's outline. @param {Pose} pose @param {number} margin squares inwards */
function ring4(pose, margin) {
  const vertices = outline(DEFAULT_BOARD);
  const [x, y] = [0, 1].map((axis) => Math.min(...vertices.map((vertex) => vertex[axis])) + margin);
  const [right, bottom] = [0, 1].map((axis) => Math.max(...vertices.map((vertex) => vertex[axis])) - margin);
  const sides = corners(x, y, right - x, bottom - y);
  return project(pose, sides.flatMap(([u, v], index) => {
    const [p, q] = sides[(index + 1) % 4];
    return Array.from({ length: EDGE_PARTS }, (_, part) => [u + ((p - u) * part) / EDGE_PARTS, v + ((q - v) * part) / EDGE_PARTS]);
  }));
}

/** @param {number} x @param {number} y @param {number} width @param {number} height */
const corners = (x, y, width, height) => [[x, y], [x + width, y], [x + width, y + height], [x, y + height]];

const lens = lensOf(LENS);

/** @param {Pose} pose @param {number[][]} points of the board, squares @returns {number[][]} px */
function project({ rvec, tvec }, points) {
  const r = rotationMatrix(rvec);
  return points.map(([x, y]) => lens.project([
    r[0] * x + r[1] * y + tvec[0], r[3] * x + r[4] * y + tvec[1], r[6] * x + r[7] * y + tvec[2],
  ]) ?? [0, 0]);
}

/** @param {number[][][]} lines */
function path(lines) {
  return lines.map((line) => `M${line.map(([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`).join("L")}${line.length > 20 ? "" : "Z"}`).join("");
}
