// Calibrations, and boards as a simulated camera sees them.
import { DEFAULT_BOARD, corners, outline } from "../../web/lib/board.js";
import { transformPoint } from "../../web/lib/pose.js";
import { projectionOf } from "../../web/lib/virtual/lens.js";
import { Painter } from "../../web/lib/virtual/painter.js";

export const PINHOLE = { fx: 1000, fy: 1000, cx: 640, cy: 360, k1: 0, k2: 0, p1: 0, p2: 0, k3: 0 };
export const CHESSBOARD = { ...DEFAULT_BOARD, kind: "chessboard", squares: [10, 7] };

/** @param {number[]} focal fx and fy, or one for both @param {number[]} centre */
export const cameraMatrix = ([fx, fy = fx], [cx, cy]) => [
  [fx, 0, cx],
  [0, fy, cy],
  [0, 0, 1],
];

/** Calibration of a lens; without distortion by default. */
export const calibrationOf = (focal, centre, more = {}) => ({
  img_size: [1280, 720],
  camera_matrix: cameraMatrix(focal, centre),
  distortion_model: "rectilinear",
  distortion_coefficients: [0, 0, 0, 0, 0],
  ...more,
});

/** Pixels of points of the board's plane. */
export function see(lens, pose, places) {
  const { project } = projectionOf(lens);
  return places.map(([x, y]) => project(transformPoint(pose, [x, y, 0])));
}

/** All corners of a board, as a detector gives them. */
export function cornersSeen(board, lens, pose) {
  const points = see(lens, pose, corners(board));
  return { ids: points.map((_, id) => id), points };
}

/** Vertices of a rectangle, clockwise from the upper left. */
export const rectangle = (left, top, width, height = width) => [
  [left, top],
  [left + width, top],
  [left + width, top + height],
  [left, top + height],
];

/** A target pose, as the service gives it. */
export function targetOf(board, lens, pose) {
  const { ids, points } = cornersSeen(board, lens, pose);
  return { ...pose, ids, corners: points, outline: see(lens, pose, outline(board)) };
}

/** Grey picture of a board; pose null: of a wall. */
export function photograph(board, lens, [width, height], pose) {
  const rgba = new Uint8ClampedArray(4 * width * height);
  new Painter(board, lens, [width, height]).paint(pose, rgba);
  return { width, height, data: Uint8Array.from({ length: width * height }, (_, pixel) => rgba[4 * pixel]) };
}

/** Distances of points from others, one by one. */
export const distances = (points, others) =>
  points.map((point, n) => Math.hypot(...point.map((value, axis) => value - others[n][axis])));

/** Root of the mean square. */
export const rms = (values) => Math.sqrt(values.reduce((sum, value) => sum + value * value, 0) / values.length);

/** True if a polygon surrounds a point. */
export function isInside([x, y], polygon) {
  let inside = false;
  polygon.forEach(([x1, y1], n) => {
    const [x2, y2] = polygon[(n + 1) % polygon.length];
    if (y1 > y !== y2 > y && x < x1 + ((y - y1) / (y2 - y1)) * (x2 - x1)) inside = !inside;
  });
  return inside;
}

/** Metrics of a frame in which nothing is wrong and no board is seen. */
export const METRICS = {
  share: 0,
  median: 110,
  high: 220,
  overexposed: 0,
  sharpness: 0.15,
  square: 0,
  moire: null,
};
