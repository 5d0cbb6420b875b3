// 3D view of cameras and boards, drawn as SVG: turned by dragging, or by sliders that show when they have the focus.
import { isBlack, outline } from "./board.js";
import { el, make } from "./dom.js";
import { t } from "./i18n.js";
import { short } from "./svg.js";
import { invert, rigidMotion, transform } from "../sdk/motion.js";
import { lensOf } from "../sdk/projection.js";

/**
 * @import { Board } from "./board.js"
 * @import { Pose } from "./pose.js"
 */

/**
 * @typedef {import("../sdk/projection.js").Intrinsics & {img_size: [number, number]}} Lens
 * @typedef {Pose & {position: number}} Station pose of a camera: camera 0 → camera
 *
 * @typedef {object} Body
 * @property {"floor" | "board" | "camera" | "axis"} kind
 * @property {number} position of the camera, of the board among the boards, or of the axis
 * @property {(readonly number[])[][]} lines polylines of points in the frame of camera 0
 * @property {(readonly number[])[][]} [dark] polygons of the board's dark squares
 * @property {readonly number[] | null} [label] point at which the camera's number stands
 *
 * @typedef {{bodies: Body[], middle: number[], radius: number}} Scene middle and radius: of a sphere around it
 */

const HALF = 200; // units: half of the drawing's width
const ASPECT = 0.5625;
const FILL = 0.88; // of the drawing that the scene fills
const FIRST = { yaw: 0.9, pitch: 0.35 }; // rad: from above, and from the side
const DRAG = 0.01; // rad a CSS pixel
const MAX_PITCH = 1.5; // rad
const DEPTH = 0.2; // of the scene's size: length of a frustum
const EDGE_STEPS = 6; // of a picture's side: the edges of a wide lens are curved
const FLOOR_CELLS = 8; // along the longer side
const FADED = 0.45; // opacity of the farthest board

/**
 * Bodies of the view: frusta of the cameras with the axes of the first one, boards, and a floor below them.
 * @param {readonly Lens[]} lenses of the cameras
 * @param {readonly Station[]} stations
 * @param {readonly Pose[]} boards board → camera 0
 * @param {Board} board @param {number} square side, in the unit of the poses
 * @returns {Scene}
 */
export function sceneOf(lenses, stations, boards, board, square) {
  const edge = outline(board).map(([x, y]) => [x * square, y * square, 0]);
  const squares = darkSquares(board).map((corners) => corners.map(([x, y]) => [x * square, y * square, 0]));
  const placed = (/** @type {Pose} */ pose, /** @type {number[][]} */ points) =>
    points.map((point) => transform(rigidMotion(pose), point));
  const sheets = boards.map((pose) => placed(pose, edge));
  const { radius } = extentOf([...stations.map((station) => invert(rigidMotion(station)).t), ...sheets.flat()]);
  const depth = DEPTH * 2 * radius;
  const bodies = /** @type {Body[]} */ ([
    ...sheets.map((sheet, position) => ({
      kind: "board",
      position,
      lines: [[...sheet, sheet[0]]],
      dark: squares.map((each) => placed(boards[position], each)),
    })),
    ...stations.map((station, index) => frustum(lenses[index], station, depth, stations.length > 1)),
  ]);
  const axes = /** @type {Body[]} */ (
    [0, 1, 2].map((axis) => ({
      kind: "axis",
      position: axis,
      lines: [[[0, 0, 0], [0, 1, 2].map((each) => (each === axis ? 0.6 * depth : 0))]],
    }))
  );
  const points = bodies.flatMap(({ lines }) => lines.flat());
  return { bodies: [floorOf(points), ...bodies, ...axes], ...extentOf(points) };
}

/** @param {Board} board @returns {number[][][]} corners of its dark squares, squares */
function darkSquares(board) {
  const [columns, rows] = board.squares;
  return Array.from({ length: columns * rows }, (_, index) => [index % columns, Math.floor(index / columns)])
    .filter(([x, y]) => isBlack(board, x, y))
    .map(([x, y]) => [
      [x, y],
      [x + 1, y],
      [x + 1, y + 1],
      [x, y + 1],
    ]);
}

/**
 * @param {Lens} calibration
 * @param {Station} station
 * @param {number} depth
 * @param {boolean} isNumbered
 * @returns {Body}
 */
function frustum(calibration, station, depth, isNumbered) {
  const {
    img_size: [width, height],
    camera_matrix: [[fx, , cx], [, fy, cy]],
  } = calibration;
  const lens = lensOf(calibration);
  const back = invert(rigidMotion(station));
  const at = (/** @type {number} */ u, /** @type {number} */ v) => {
    const ray = lens.unproject([u, v]) ?? [(u - cx) / fx, (v - cy) / fy, 1];
    const length = Math.hypot(...ray);
    return transform(
      back,
      ray.map((value) => (value * depth) / length),
    );
  };
  const [right, bottom] = [width - 0.5, height - 0.5];
  const vertices = [
    [-0.5, -0.5],
    [right, -0.5],
    [right, bottom],
    [-0.5, bottom],
  ];
  const rim = vertices.flatMap(([u, v], index) => {
    const [u1, v1] = vertices[(index + 1) % 4];
    return Array.from({ length: EDGE_STEPS }, (_, step) =>
      at(u + ((u1 - u) * step) / EDGE_STEPS, v + ((v1 - v) * step) / EDGE_STEPS),
    );
  });
  const rays = vertices.map(([u, v]) => [back.t, at(u, v)]);
  return {
    kind: "camera",
    position: station.position,
    lines: [[...rim, rim[0]], ...rays],
    label: isNumbered ? back.t : null,
  };
}

/** Grid below all points; y points down. @param {(readonly number[])[]} points @returns {Body} */
function floorOf(points) {
  const [[left, right], [, bottom], [near, far]] = boundsOf(points);
  const step = Math.max(right - left, far - near, 1e-9) / FLOOR_CELLS;
  const along = (/** @type {number} */ low, /** @type {number} */ high) => {
    const count = Math.max(1, Math.ceil((high - low) / step));
    const first = (low + high - count * step) / 2;
    return Array.from({ length: count + 1 }, (_, index) => first + index * step);
  };
  const [xs, zs] = [along(left, right), along(near, far)];
  const [[x0, x1], [z0, z1]] = [xs, zs].map((all) => [all[0], all[all.length - 1]]);
  return {
    kind: "floor",
    position: 0,
    lines: [
      ...xs.map((x) => [
        [x, bottom, z0],
        [x, bottom, z1],
      ]),
      ...zs.map((z) => [
        [x0, bottom, z],
        [x1, bottom, z],
      ]),
    ],
  };
}

/** @param {(readonly number[])[]} points @returns {[number, number][]} by axis */
const boundsOf = (points) =>
  [0, 1, 2].map((axis) => {
    const values = points.map((point) => point[axis]);
    return /** @type {[number, number]} */ ([Math.min(...values), Math.max(...values)]);
  });

/** @param {(readonly number[])[]} points */
function extentOf(points) {
  const middle = boundsOf(points).map(([low, high]) => (low + high) / 2);
  return {
    middle,
    radius: Math.max(1e-9, ...points.map((point) => Math.hypot(...point.map((value, axis) => value - middle[axis])))),
  };
}

/**
 * Place of a point in the drawing, looked at from a direction.
 * @param {readonly number[]} point @param {Scene} scene @param {number} yaw rad @param {number} pitch rad
 * @returns {[number, number, number]} x right and y down, -1 to 1; depth
 */
function drawnPoint(point, { middle, radius }, yaw, pitch) {
  const [x, y, z] = point.map((value, axis) => (value - middle[axis]) / radius);
  const [cosYaw, sinYaw, cosPitch, sinPitch] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
  const [u, w] = [cosYaw * x + sinYaw * z, -sinYaw * x + cosYaw * z];
  return [u, cosPitch * y - sinPitch * w, sinPitch * y + cosPitch * w];
}

/**
 * @param {Scene} scene @param {string} label for those who cannot see it
 * @param {readonly number[]} [views] indices of the views that the boards are of, which other figures of them share
 */
export function scenePlot(scene, label, views = []) {
  const svg = make("svg", {
    viewBox: `${-HALF} ${-HALF * ASPECT} ${2 * HALF} ${2 * HALF * ASPECT}`,
    role: "img",
    "aria-label": label,
    class: "scene",
  });
  const view = { ...FIRST };
  const yaw = slider(t("common.turn"), -Math.PI, Math.PI, view.yaw);
  const pitch = slider(t("common.tilt"), -MAX_PITCH, MAX_PITCH, view.pitch);
  const draw = () => svg.replaceChildren(...drawing(scene, view.yaw, view.pitch, views));
  const set = (/** @type {number} */ turn, /** @type {number} */ tilt) => {
    view.yaw = Math.atan2(Math.sin(turn), Math.cos(turn));
    view.pitch = Math.min(MAX_PITCH, Math.max(-MAX_PITCH, tilt));
    yaw.value = String(view.yaw);
    pitch.value = String(view.pitch);
    draw();
  };
  for (const each of [yaw, pitch]) each.addEventListener("input", () => set(Number(yaw.value), Number(pitch.value)));
  svg.addEventListener("pointerdown", (event) => svg.setPointerCapture(event.pointerId));
  svg.addEventListener("pointermove", (event) => {
    if (event.buttons) set(view.yaw + DRAG * event.movementX, view.pitch - DRAG * event.movementY);
  });
  draw();
  return el(
    "div",
    { class: "scene-view" },
    svg,
    el(
      "div",
      { class: "fields" },
      ...[yaw, pitch].map((input) =>
        el("label", { class: "field" }, el("span", { class: "label" }, input.title), input),
      ),
    ),
  );
}

/** @param {string} title @param {number} min @param {number} max @param {number} value */
function slider(title, min, max, value) {
  const input = el("input", { type: "range", min, max, step: 0.01, title });
  input.value = String(value);
  return input;
}

/**
 * @param {Scene} scene @param {number} yaw rad @param {number} pitch rad @param {readonly number[]} views
 * @returns {SVGElement[]} the farthest first, the floor before all
 */
function drawing(scene, yaw, pitch, views) {
  const bodies = scene.bodies.map((body) => {
    const place = (/** @type {readonly number[]} */ point) => drawnPoint(point, scene, yaw, pitch);
    const lines = body.lines.map((line) => line.map(place));
    const depths = lines.flat().map(([, , depth]) => depth);
    const depth = body.kind === "floor" ? Infinity : depths.reduce((sum, each) => sum + each, 0) / depths.length;
    return {
      ...body,
      lines,
      dark: (body.dark ?? []).map((polygon) => polygon.map(place)),
      label: body.label ? place(body.label) : null,
      depth,
    };
  });
  const [[left, right], [top, bottom]] = boundsOf(
    bodies.filter(({ kind }) => kind !== "floor").flatMap(({ lines }) => lines.flat()),
  );
  const scale = FILL * 2 * HALF * Math.min(1 / Math.max(right - left, 1e-9), ASPECT / Math.max(bottom - top, 1e-9));
  const at = (/** @type {readonly number[]} */ [x, y]) =>
    `${short((x - (left + right) / 2) * scale)} ${short((y - (top + bottom) / 2) * scale)}`;
  const path = (/** @type {(readonly number[])[][]} */ lines) =>
    lines.map((line) => `M${line.map(at).join("L")}`).join("");
  const boards = bodies.filter(({ kind }) => kind === "board").map(({ depth }) => depth);
  const [near, far] = [Math.min(...boards), Math.max(...boards)];
  return bodies
    .sort((a, b) => b.depth - a.depth)
    .map(({ kind, position, lines, dark, label, depth }) => {
      const isBoard = kind === "board";
      const parts = [
        make("path", { d: path(lines) }),
        ...(isBoard ? [make("path", { d: path(dark), class: "dark" })] : []),
      ];
      if (label) {
        const [x, y] = at(label).split(" ");
        parts.push(
          make("circle", { cx: x, cy: y, r: 3 }),
          make("text", { x, y: Number(y) - 8, "text-anchor": "middle" }, [String(position + 1)]),
        );
      }
      return make(
        "g",
        {
          class:
            kind === "axis" ? `axis-${"xyz"[position]}` : kind === "camera" && position === 0 ? "camera first" : kind,
          ...(isBoard && far > near ? { opacity: short(1 - ((1 - FADED) * (depth - near)) / (far - near)) } : {}),
          ...(isBoard && position in views ? { "data-view": views[position] } : {}),
        },
        parts,
      );
    });
}
