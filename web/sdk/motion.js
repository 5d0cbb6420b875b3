// Rigid motions, x → R x + t, as rotation vector and translation: conversion, composition, inverse.

/**
 * @typedef {object} Motion
 * @property {readonly number[]} rvec rotation vector: axis times angle, radians
 * @property {readonly number[]} tvec translation
 *
 * @typedef {object} RigidMotion
 * @property {readonly number[]} r rotation, row-major 3x3
 * @property {readonly number[]} t translation
 */

/** Rodrigues' formula. @param {readonly number[]} rvec @returns {number[]} row-major 3x3 */
export function rotationMatrix([x, y, z]) {
  const angle = Math.hypot(x, y, z);
  if (angle < 1e-12) return [1, -z, y, z, 1, -x, -y, x, 1];
  const [a, b, c] = [x / angle, y / angle, z / angle];
  const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
  const k = 1 - cos;
  return [
    cos + a * a * k,
    a * b * k - c * sin,
    a * c * k + b * sin,
    a * b * k + c * sin,
    cos + b * b * k,
    b * c * k - a * sin,
    a * c * k - b * sin,
    b * c * k + a * sin,
    cos + c * c * k,
  ];
}

/**
 * Inverse of `rotationMatrix`.
 * @param {readonly number[]} matrix row-major 3x3 rotation
 * @returns {number[]} rotation vector
 */
export function rotationVectorOf(matrix) {
  return rotationVector(quaternionOf(matrix));
}

/** Unit quaternion of a rotation. @param {readonly number[]} matrix row-major 3x3 @returns {number[]} w x y z */
export function quaternionOf([a, b, c, d, e, f, g, h, i]) {
  // Of the four ways to the quaternion the one that divides by the largest (Shepperd 1978).
  const squares = [1 + a + e + i, 1 + a - e - i, 1 - a + e - i, 1 - a - e + i];
  const largest = squares.indexOf(Math.max(...squares));
  const q = [
    [squares[0], h - f, c - g, d - b],
    [h - f, squares[1], b + d, c + g],
    [c - g, b + d, squares[2], f + h],
    [d - b, c + g, f + h, squares[3]],
  ][largest];
  const length = Math.hypot(...q);
  return q.map((value) => value / length);
}

/** Rotation vector of a unit quaternion. @param {readonly number[]} q w x y z @returns {number[]} */
export function rotationVector([w, x, y, z]) {
  const sign = w < 0 ? -1 : 1;
  const sin = Math.hypot(x, y, z);
  const scale = sin < 1e-12 ? 2 * sign : ((2 * Math.atan2(sin, sign * w)) / sin) * sign;
  return [x * scale, y * scale, z * scale];
}

/** @param {Motion} motion @returns {RigidMotion} */
export const rigidMotion = ({ rvec, tvec }) => ({ r: rotationMatrix(rvec), t: tvec });

/** First b, then a. @param {RigidMotion} a @param {RigidMotion} b @returns {RigidMotion} */
export const compose = (a, b) => ({ r: multiply(a.r, b.r), t: transform(a, b.t) });

/** @param {RigidMotion} motion @returns {RigidMotion} the way back */
export function invert({ r, t }) {
  const back = transpose(r);
  return { r: back, t: rotate(back, t).map((value) => -value) };
}

/** Point after a motion. @param {RigidMotion} motion @param {readonly number[]} point */
export const transform = ({ r, t }, point) => rotate(r, point).map((value, axis) => value + t[axis]);

/** Vector after a rotation. @param {readonly number[]} r row-major 3x3 @param {readonly number[]} v */
export const rotate = (r, [x, y, z]) => [0, 3, 6].map((row) => r[row] * x + r[row + 1] * y + r[row + 2] * z);

/** @param {readonly number[]} r row-major 3x3 @returns {number[]} */
export const transpose = (r) => [0, 1, 2].flatMap((column) => [r[column], r[column + 3], r[column + 6]]);

/** @param {readonly number[]} a @param {readonly number[]} b row-major 3x3 @returns {number[]} row-major 3x3 */
export function multiply(a, b) {
  const columns = transpose(b);
  return transpose([0, 3, 6].flatMap((column) => rotate(a, columns.slice(column, column + 3))));
}

/** @param {readonly number[]} r row-major 3x3 @returns {number[][]} its rows */
export const rowsOf = (r) => [0, 3, 6].map((row) => r.slice(row, row + 3));
