// Calibration files that are JSON: PhotonVision's with what was seen, and cameras without. Pure.
import { MalformedError } from "./grid.js";
import { square } from "./text.js";

/** @import { View } from "./grid.js" */

const VIEWS = 1000; // more than any capture has
const POINTS = 10_000; // of a view
const MAX_NUMBER = 1e12; // beyond which no number is a camera's

/** Value at a path, undefined where there is none. @param {unknown} data @param {string[]} path @returns {unknown} */
function at(data, ...path) {
  return path.reduce(
    (/** @type {unknown} */ here, key) =>
      here !== null && typeof here === "object" && Object.hasOwn(here, key)
        ? /** @type {Record<string, unknown>} */ (here)[key]
        : undefined,
    data,
  );
}

/** @param {unknown} value @param {string} what @returns {number} */
function finite(value, what) {
  if (typeof value !== "number" || !(Math.abs(value) < MAX_NUMBER)) throw new MalformedError("number", { what });
  return value;
}

/** True for a file of PhotonVision. @param {unknown} data */
export const isPhotonVision = (data) => at(data, "cameraIntrinsics") !== undefined;

/**
 * Views of a PhotonVision file.
 * @param {unknown} data
 * @returns {{size: [number, number], views: View[]}} throws MalformedError; no views: it holds none
 */
export function photonVision(data) {
  const size = ["width", "height"].map((name) => {
    const value = finite(at(data, "resolution", name), `resolution.${name}`);
    if (!Number.isInteger(value) || value < 1) throw new MalformedError("number", { what: `resolution.${name}` });
    return value;
  });
  const seen = at(data, "observations") ?? [];
  if (!Array.isArray(seen) || seen.length > VIEWS) throw new MalformedError("many", { most: VIEWS });
  return { size: [size[0], size[1]], views: seen.map(observation).filter(({ image }) => image.length > 0) };
}

/** @param {unknown} item @param {number} index @returns {View} */
function observation(item, index) {
  const object = points(at(item, "locationInObjectSpace"), ["x", "y", "z"], "locationInObjectSpace");
  const image = points(at(item, "locationInImageSpace"), ["x", "y"], "locationInImageSpace");
  if (object.length !== image.length) throw new MalformedError("count", { index: index + 1 });
  const flags = at(item, "cornersUsed");
  const used = Array.isArray(flags) && flags.length === image.length ? flags : null;
  // Corners that were not seen are written as negative pixels.
  const kept = image.map(([x, y], number) => x >= -0.5 && y >= -0.5 && (used === null || Boolean(used[number])));
  const name = at(item, "snapshotName");
  return {
    name: typeof name === "string" && name ? name.slice(0, 80) : String(index + 1),
    object: object.filter((_, number) => kept[number]),
    image: image.filter((_, number) => kept[number]),
  };
}

/** @param {unknown} items @param {string[]} axes @param {string} what @returns {number[][]} */
function points(items, axes, what) {
  if (!Array.isArray(items) || items.length > POINTS) throw new MalformedError("number", { what });
  return items.map((item) => axes.map((axis) => finite(at(item, axis), what)));
}

/** Paths at which tools keep the camera matrix. */
const MATRICES = [
  ["cameraIntrinsics", "data"],
  ["camera_matrix", "data"],
  ["camera_matrix"],
  ["fisheye_params", "camera_matrix"],
  ["K"],
  ["mtx"],
];

/** The camera matrix in a file, null where none is found. @param {unknown} data @returns {number[][] | null} */
export function cameraMatrix(data) {
  for (const path of MATRICES) {
    const found = at(data, ...path);
    const flat = Array.isArray(found) ? found.flat(1) : [];
    if (flat.length === 9 && flat.every((value) => typeof value === "number" && Number.isFinite(value))) {
      return [flat.slice(0, 3), flat.slice(3, 6), flat.slice(6)];
    }
  }
  return nestedMatrix(data, 0);
}

const MATRIX_NAMES = /^(k|mtx|m\d?|cam(era)?mat(rix)?|(camera)?intrinsics?(matrix)?)(left|right|\d{1,2})?$/;
const FOCALS = [
  ["fx", "fy", "cx", "cy"],
  ["fx", "fy", "ppx", "ppy"],
  ["fl_x", "fl_y", "cx", "cy"],
];
const MAX_DEPTH = 6;
const MAX_MEMBERS = 200; // of an object that is searched

/**
 * The first camera matrix at any depth, under any of its usual names or as four numbers.
 * @param {unknown} data
 * @param {number} depth
 * @returns {number[][] | null}
 */
function nestedMatrix(data, depth) {
  if (data === null || typeof data !== "object" || depth > MAX_DEPTH) return null;
  for (const names of FOCALS) {
    const [fx, fy, cx, cy] = names.map((name) => at(data, name));
    if ([fx, fy, cx, cy].every((value) => typeof value === "number" && Number.isFinite(value))) {
      return /** @type {number[][]} */ ([
        [fx, 0, cx],
        [0, fy, cy],
        [0, 0, 1],
      ]);
    }
  }
  const members = Object.entries(data).slice(0, MAX_MEMBERS);
  for (const [name, value] of members) {
    if (!MATRIX_NAMES.test(name.toLowerCase().replace(/[^a-z0-9]/g, ""))) continue;
    const held = at(value, "data") ?? value;
    const found = Array.isArray(held) ? square(held.flat(1)) : null;
    if (found) return found;
  }
  for (const [, value] of members) {
    const found = typeof value === "object" ? nestedMatrix(value, depth + 1) : null;
    if (found) return found;
  }
  return null;
}
