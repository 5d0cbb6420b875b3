// Picture of a guided capture: a board that is led to the amber outline, again and again. Board, poses and lens are
// those of the capture page, drawn small.
import { DEFAULT_BOARD, isBlack, markers, outline } from "../lib/board.js";
import { t } from "../lib/i18n.js";
import { interpolatePose, rotationMatrix } from "../lib/pose.js";
import { LENS, SIZE, TARGETS } from "../lib/rig-picture.js";
import { make } from "../lib/dom.js";
import { lensOf } from "../sdk/projection.js";

/** @import { Pose } from "../lib/pose.js" */

const START = { rvec: [0.2, -0.3, 0.3], tvec: [-6.5, -1.2, 14] };
const MOVE_MS = 1500;
const HOLD_MS = 900;
const STEP_MS = MOVE_MS + HOLD_MS;
const STRAIGHTEN_MS = 900;
const END_MS = 3200; // the verdict stands for so long
/** Bits of the board's markers in their order, four digits each. */
export const BITS =
  "b5320f9a332d9946549e79cd9e2ec4f2fedacf56f99111a70eb72a0f24b1263e466566006c5e76af868bb02bccd5dd82fe479471ace4";
/** Blurred room behind the board: a window, a lamp, a plant, a desk. */
const ROOM = [
  { cx: 120, cy: 60, rx: 110, ry: 80, fill: "#7d94a6" },
  { cx: 470, cy: 40, rx: 60, ry: 50, fill: "#e0a860" },
  { cx: 590, cy: 170, rx: 60, ry: 110, fill: "#3f5a44" },
  { cx: 320, cy: 380, rx: 460, ry: 120, fill: "#6b4a31" },
  { cx: 90, cy: 300, rx: 60, ry: 22, fill: "#c9c2b4" },
];
const STILL_MS = 0.62 * MOVE_MS; // still frame for reduced motion: board and target are apart
// Progress, as on the capture page: the outline of each pose, filled once its view is taken
const FILM_LEFT = 398;
const FILM_STEP = 58;
const FILM_SIZE = { width: 51.2, height: 28.8 };
const EDGE_PARTS = 4; // of a side that the lens bends

/**
 * Draws the loop in a figure and plays it while it is in sight.
 * @param {SVGElement} svg
 * @param {HTMLElement} words for the instruction
 * @param {HTMLButtonElement} toggle stops and plays it
 */
export function captureLoop(svg, words, toggle) {
  svg.setAttribute("viewBox", `0 0 ${SIZE[0]} ${SIZE[1]}`);
  const room = make(
    "g",
    { class: "room" },
    ROOM.map((attributes) => make("ellipse", attributes)),
  );
  const [paper, black, white, target] = ["paper", "black", "paper", "wanted"].map((name) =>
    make("path", { class: name }),
  );
  const ring = make("circle", { class: "held", cx: 46, cy: 46, r: 20, pathLength: 100 });
  const film = TARGETS.map((pose, index) =>
    make(
      "svg",
      {
        class: "frame",
        x: FILM_LEFT + FILM_STEP * index,
        y: 14,
        ...FILM_SIZE,
        viewBox: svg.getAttribute("viewBox") ?? "",
      },
      [make("rect", { width: SIZE[0], height: SIZE[1] }), make("path", { d: path([ring4(pose, 0)]) })],
    ),
  );
  svg.replaceChildren(room, paper, black, white, target, ring, ...film);

  const still = matchMedia("(prefers-reduced-motion: reduce)");
  let playing = !still.matches;
  let seen = true;
  let at = still.matches ? STILL_MS : 0;
  let before = 0;

  const draw = () => {
    const { pose, wanted, held, said, taken, strength = 1 } = scene(at);
    const areas = (/** @type {number[][][]} */ all) => path(all.map((area) => project(pose, strength, area)));
    paper.setAttribute("d", path([ring4(pose, -0.35, strength)]));
    black.setAttribute("d", areas([...SQUARES, ...FRAMES]));
    white.setAttribute("d", areas(CELLS));
    target.setAttribute("d", wanted ? path([ring4(wanted, 0)]) : "");
    ring.setAttribute("stroke-dasharray", `${100 * held} 100`);
    film.forEach((each, index) => each.classList.toggle("taken", index < taken));
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
  const over = at - TARGETS.length * STEP_MS;
  if (over >= 0)
    return {
      pose,
      wanted: null,
      held: 0,
      said: () => t("landing.loop_done"),
      taken: TARGETS.length,
      strength: Math.max(0, 1 - over / STRAIGHTEN_MS),
    };
  const held = Math.max(0, Math.min(1, (since - MOVE_MS) / (HOLD_MS - 200)));
  return {
    pose,
    wanted: to,
    held,
    taken: held < 1 ? step : step + 1,
    said: () =>
      t(moved < 1 ? "landing.loop_follow" : held < 1 ? "landing.loop_hold" : "landing.loop_taken", { count: step + 1 }),
  };
}

const [COLUMNS, ROWS] = DEFAULT_BOARD.squares;
const SQUARES = Array.from({ length: COLUMNS * ROWS }, (_, index) => [index % COLUMNS, Math.floor(index / COLUMNS)])
  .filter(([x, y]) => isBlack(DEFAULT_BOARD, x, y))
  .map(([x, y]) => corners(x, y, 1, 1));
const MARKERS = markers(DEFAULT_BOARD);
const RATIO = DEFAULT_BOARD.marker_ratio;
const MARGIN = (1 - RATIO) / 2;
const FRAMES = MARKERS.map(({ x, y }) => corners(x + MARGIN, y + MARGIN, RATIO, RATIO));
/** White cells of the markers, which have a black frame one cell wide. */
const CELLS = MARKERS.flatMap(({ x, y }, index) => {
  const [bits, cell] = [parseInt(BITS.slice(4 * index, 4 * index + 4), 16), RATIO / 6];
  return Array.from({ length: 16 }, (_, bit) => bit)
    .filter((bit) => (bits >> (15 - bit)) & 1)
    .map((bit) =>
      corners(x + MARGIN + (1 + (bit % 4)) * cell, y + MARGIN + (1 + Math.floor(bit / 4)) * cell, cell, cell),
    );
});

/**
 * The board's outline.
 * @param {Pose} pose
 * @param {number} margin squares inwards
 * @param {number} [strength] of the distortion
 */
function ring4(pose, margin, strength = 1) {
  const vertices = outline(DEFAULT_BOARD);
  const [x, y] = [0, 1].map((axis) => Math.min(...vertices.map((vertex) => vertex[axis])) + margin);
  const [right, bottom] = [0, 1].map((axis) => Math.max(...vertices.map((vertex) => vertex[axis])) - margin);
  const sides = corners(x, y, right - x, bottom - y);
  return project(
    pose,
    strength,
    sides.flatMap(([u, v], index) => {
      const [p, q] = sides[(index + 1) % 4];
      return Array.from({ length: EDGE_PARTS }, (_, part) => [
        u + ((p - u) * part) / EDGE_PARTS,
        v + ((q - v) * part) / EDGE_PARTS,
      ]);
    }),
  );
}

/** @param {number} x @param {number} y @param {number} width @param {number} height */
function corners(x, y, width, height) {
  return [
    [x, y],
    [x + width, y],
    [x + width, y + height],
    [x, y + height],
  ];
}

/**
 * @param {Pose} pose
 * @param {number} strength of the distortion
 * @param {number[][]} points of the board, squares
 * @returns {number[][]} px
 */
function project({ rvec, tvec }, strength, points) {
  const r = rotationMatrix(rvec);
  const lens = lensOf({
    ...LENS,
    distortion_coefficients: LENS.distortion_coefficients.map((value) => value * strength),
  });
  return points.map(
    ([x, y]) =>
      lens.project([r[0] * x + r[1] * y + tvec[0], r[3] * x + r[4] * y + tvec[1], r[6] * x + r[7] * y + tvec[2]]) ?? [
        0, 0,
      ],
  );
}

/** @param {number[][][]} lines */
function path(lines) {
  return lines
    .map(
      (line) => `M${line.map(([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`).join("L")}${line.length > 20 ? "" : "Z"}`,
    )
    .join("");
}
