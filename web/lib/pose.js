// Rigid motions as rotation vector and translation, board → camera: conversion, interpolation, perturbation.
import { rotationMatrix, rotationVector } from "../sdk/motion.js";

export { rotationMatrix, rotationVectorOf } from "../sdk/motion.js";

/** @typedef {{rvec: number[], tvec: number[]}} Pose */

/** @param {number[]} rvec @returns {number[]} unit quaternion w x y z */
function quaternion([x, y, z]) {
  const angle = Math.hypot(x, y, z);
  const scale = angle < 1e-12 ? 0.5 : Math.sin(angle / 2) / angle;
  return [Math.cos(angle / 2), x * scale, y * scale, z * scale];
}

/** Quaternion product: first b, then a. @param {number[]} a @param {number[]} b */
function times([a, b, c, d], [e, f, g, h]) {
  return [
    a * e - b * f - c * g - d * h,
    a * f + b * e + c * h - d * g,
    a * g - b * h + c * e + d * f,
    a * h + b * g - c * f + d * e,
  ];
}

/** On the way from one pose to another. @param {Pose} from @param {Pose} to @param {number} part 0…1 @returns {Pose} */
export function interpolatePose(from, to, part) {
  const [start, end] = [quaternion(from.rvec), quaternion(to.rvec)];
  const turn = rotationVector(times(end, [start[0], -start[1], -start[2], -start[3]]));
  return {
    rvec: rotationVector(times(quaternion(turn.map((value) => value * part)), start)),
    tvec: from.tvec.map((value, index) => value + part * (to.tvec[index] - value)),
  };
}

/**
 * Pose in which a person shown `target` holds the board: turned by about 3° and 3 % of the distance off, times
 * `amount`.
 * @param {Pose} target @param {number} amount 0 = a robot @param {() => number} random uniform 0…1
 * @param {number[]} pivot centre of the board, board frame: the hand turns the board about it
 * @returns {Pose}
 */
export function perturbPose(target, amount, random, pivot) {
  // Two uniforms make a triangular distribution, near enough to a hand; its standard deviation is 1 / √6.
  const wobble = () => (random() + random() - 1) * Math.sqrt(6);
  const angle = (amount * 3 * Math.PI) / 180 / Math.sqrt(3);
  const turn = [wobble(), wobble(), wobble()].map((value) => value * angle);
  const distance = Math.hypot(...transformPoint(target, pivot));
  const shift = [wobble(), wobble(), wobble()].map((value) => (value * amount * 0.03 * distance) / Math.sqrt(3));
  const rvec = rotationVector(times(quaternion(turn), quaternion(target.rvec)));
  const before = transformPoint(target, pivot);
  const turned = transformPoint({ rvec, tvec: [0, 0, 0] }, pivot);
  return { rvec, tvec: before.map((value, index) => value - turned[index] + shift[index]) };
}

/** @param {Pose} pose @param {number[]} point board frame @returns {number[]} camera frame */
export function transformPoint({ rvec, tvec }, [x, y, z]) {
  const r = rotationMatrix(rvec);
  return [0, 1, 2].map((row) => r[3 * row] * x + r[3 * row + 1] * y + r[3 * row + 2] * z + tvec[row]);
}

/** Motion that makes first the second motion, then the first. @param {Pose} a @param {Pose} b @returns {Pose} */
export function composePoses(a, b) {
  return { rvec: rotationVector(times(quaternion(a.rvec), quaternion(b.rvec))), tvec: transformPoint(a, b.tvec) };
}

/** Motion back. @param {Pose} pose @returns {Pose} */
export function invertPose({ rvec, tvec }) {
  const back = rvec.map((value) => -value);
  const turned = transformPoint({ rvec: back, tvec: [0, 0, 0] }, tvec);
  return { rvec: back, tvec: turned.map((value) => -value) };
}

/** A small seeded generator (mulberry32): the same seed, the same hand. @param {number} seed @returns {() => number} */
export function seededRandom(seed) {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let mixed = Math.imul(state ^ (state >>> 15), 1 | state);
    mixed = (mixed + Math.imul(mixed ^ (mixed >>> 7), 61 | mixed)) ^ mixed;
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 4294967296;
  };
}
