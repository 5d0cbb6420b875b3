// Drawing of the examples: a box that stands on the board, and a mark on each of the board's outer corners.
import { DEFAULT_BOARD } from "../lib/board.js";
import { rotationMatrix } from "../lib/pose.js";

/**
 * @typedef {[number, number, number]} Point board frame: x right, y down, z away from the viewer; squares
 * @typedef {import("../lib/pose.js").Pose} Pose
 */

const [COLUMNS, ROWS] = DEFAULT_BOARD.squares;
const DISTANCE = 1.6; // of the board, in widths of what the camera sees there
const SWING_S = 9; // s for one turn of the board's motion

export const MARK = 0.4; // side, squares
export const BOX = 2; // side, squares

/** @type {Point[]} */
export const MARKS = [
  [0, 0, 0],
  [COLUMNS, 0, 0],
  [COLUMNS, ROWS, 0],
  [0, ROWS, 0],
];
/** Centre of the box. @type {Point} */
export const CENTRE = [COLUMNS / 2, ROWS / 2, -BOX / 2];

/**
 * Pose of the board at a time: turned to and fro, its middle before the camera. Before a real camera, where nothing is
 * tracked here, it stands upright in the same place.
 * @param {{img_size: readonly [number, number], camera_matrix: number[][]}} calibration
 * @param {number} seconds 0: upright
 * @returns {Pose} board → camera, squares
 */
export function poseAt({ img_size: [width], camera_matrix: [[fx]] }, seconds) {
  const angle = (2 * Math.PI * seconds) / SWING_S;
  const rvec = [0.45 * Math.sin(angle), 0.5 * Math.sin(2 * angle), 0];
  const r = rotationMatrix(rvec);
  const middle = [0, 1, 2].map((row) => r[3 * row] * (COLUMNS / 2) + r[3 * row + 1] * (ROWS / 2));
  return { rvec, tvec: [-middle[0], -middle[1], (DISTANCE * COLUMNS * fx) / width - middle[2]] };
}

/**
 * Pose as the matrix of an engine whose y points up, for points with the same signs: (x, −y, −z) of OpenCV's where z
 * points to the viewer (three.js, A-Frame), (x, −y, z) where it points away (Babylon.js).
 * @param {Pose} pose @param {1 | -1} depth sign of z
 * @returns {number[]} 4x4, column by column
 */
export function poseMatrix({ rvec, tvec }, depth) {
  const signs = [1, -1, depth];
  const r = rotationMatrix(rvec);
  const columns = [0, 1, 2].map((column) => [
    ...[0, 1, 2].map((row) => signs[row] * signs[column] * r[3 * row + column]),
    0,
  ]);
  return [...columns.flat(), ...tvec.map((value, row) => signs[row] * value), 1];
}
