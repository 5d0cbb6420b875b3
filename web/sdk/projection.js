// Projection of rays to pixels and back, for every camera model that calibDB hands out. One file without dependencies.
//
//     import { lensOf } from "https://<host>/sdk/projection.js";
//     const lens = lensOf(calibration);
//     lens.project([0.1, 0, 1]); // → [u, v] px, or null where the lens sees nothing
//     lens.unproject([640, 360]); // → unit ray, x right, y down, z forward, or null
//
// Pixels are OpenCV's: the centre of the top-left one is (0, 0). Formulas after OpenCV's documentation ("Camera
// Calibration and 3D Reconstruction", "Fisheye camera model") and, for `omnidirectional`, Mei & Rives (ICRA 2007).

/**
 * @typedef {object} Intrinsics of a calibration; see calibdb.js
 * @property {number[][]} camera_matrix row-major 3x3, px
 * @property {number[]} distortion_coefficients
 * @property {string} distortion_model
 *
 * @typedef {object} Lens
 * @property {(ray: readonly number[]) => [number, number] | null} project ray of any length, camera frame → px
 * @property {(pixel: readonly number[]) => [number, number, number] | null} unproject px → unit ray
 * @property {number} limit largest angle from the axis at which the model is one-to-one, radians
 *
 * @typedef {object} Curve how far from the axis a ray meets the plane of unit focal length, before tangential terms
 * @property {(t: number) => number} at
 * @property {(t: number) => number} slope
 * @property {number} end the argument's end, at most
 */

/** Names of the coefficients, in the order of `distortion_coefficients`. @type {Record<string, string[]>} */
export const COEFFICIENTS = {
  rectilinear: ["k1", "k2", "p1", "p2", "k3"],
  fisheye: ["k1", "k2", "k3", "k4"],
  rational: ["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"],
  omnidirectional: ["xi", "k1", "k2", "p1", "p2"],
};

const MAX_TANGENT = 50; // tan of the largest angle, 88.9°, at which a pinhole's models are used
const INVERSE_STEPS = 512;
const TOLERANCE = 1e-13;
/** Newton's method settles in four or five; where it has not in these, there is no such ray. */
const MAX_ITERATIONS = 30;

/** A calibration is of a camera model that is newer than this SDK. */
export class UnknownModelError extends RangeError {
  /** @param {string} model */
  constructor(model) {
    super(`this version of the calibDB SDK knows no camera model "${model}"`);
    this.name = "UnknownModelError";
    this.model = model;
  }
}

/** @param {string} model */
export const isKnownModel = (model) => Object.hasOwn(COEFFICIENTS, model);

/**
 * The lens of a calibration.
 * @param {Intrinsics} intrinsics
 * @returns {Lens} throws UnknownModelError
 */
export function lensOf({ camera_matrix: [[fx, , cx], [, fy, cy]], distortion_coefficients: d, distortion_model }) {
  const { distort, undistort, limit } = plane(distortion_model, d);
  return {
    limit,
    project([x, y, z]) {
      const at = distort(x, y, z);
      return at && [fx * at[0] + cx, fy * at[1] + cy];
    },
    unproject([u, v]) {
      return undistort((u - cx) / fx, (v - cy) / fy);
    },
  };
}

/** The model without its camera matrix. @param {string} model @param {number[]} d */
function plane(model, d) {
  if (model === "fisheye") return kannalaBrandt(d);
  if (model === "omnidirectional") return unified(d);
  if (isKnownModel(model)) return pinhole(d);
  throw new UnknownModelError(model);
}

/** Rectilinear and rational; the former has no denominator. @param {number[]} d */
function pinhole(d) {
  const brown = brownConrady(d, MAX_TANGENT);
  return {
    limit: Math.atan(brown.end),
    /** @param {number} x @param {number} y @param {number} z */
    distort: (x, y, z) => (z > 0 ? brown.distort(x / z, y / z) : null),
    /** @param {number} u @param {number} v */
    undistort(u, v) {
      const at = brown.undistort(u, v);
      return at && unit(at[0], at[1], 1);
    },
  };
}

/** The unit sphere seen from xi behind its centre, then Brown's distortion without k3. @param {number[]} d */
function unified([xi, k1, k2, p1, p2]) {
  // The image radius sin t / (cos t + xi) grows up to here.
  const widest = xi <= 1 ? Math.acos(-xi) : Math.acos(-1 / xi);
  const radius = (/** @type {number} */ t) => Math.sin(t) / (Math.cos(t) + xi);
  const brown = brownConrady([k1, k2, p1, p2, 0], Math.min(radius(widest - 1e-6), 1e4));
  const limit = bisect((t) => radius(t) < brown.end, 0, widest);
  return {
    limit,
    /** @param {number} x @param {number} y @param {number} z */
    distort(x, y, z) {
      if (Math.atan2(Math.hypot(x, y), z) > limit) return null;
      const depth = z + xi * Math.hypot(x, y, z);
      return brown.distort(x / depth, y / depth);
    },
    /** @param {number} u @param {number} v */
    undistort(u, v) {
      const at = brown.undistort(u, v);
      if (!at) return null;
      const s = at[0] * at[0] + at[1] * at[1];
      const inside = 1 + (1 - xi * xi) * s;
      if (inside < 0) return null;
      const eta = (xi + Math.sqrt(inside)) / (s + 1);
      return unit(eta * at[0], eta * at[1], eta - xi);
    },
  };
}

/** The image radius is a polynomial of the angle, which atan2 gives beyond 90° too. @param {number[]} d */
function kannalaBrandt([k1, k2, k3, k4]) {
  /** @type {Curve} */
  const curve = {
    at: (t) => t * (1 + t * t * (k1 + t * t * (k2 + t * t * (k3 + t * t * k4)))),
    slope: (t) => 1 + t * t * (3 * k1 + t * t * (5 * k2 + t * t * (7 * k3 + t * t * 9 * k4))),
    end: Math.PI,
  };
  const inverse = invert(curve);
  return {
    limit: inverse.end,
    /** @param {number} x @param {number} y @param {number} z */
    distort(x, y, z) {
      const r = Math.hypot(x, y);
      const t = Math.atan2(r, z);
      if (t > inverse.end) return null;
      const m = r > 0 ? curve.at(t) / r : 0;
      return /** @type {[number, number]} */ ([x * m, y * m]);
    },
    /** @param {number} u @param {number} v */
    undistort(u, v) {
      const r = Math.hypot(u, v);
      const t = inverse.find(r);
      if (t === null) return null;
      const m = r > 0 ? Math.sin(t) / r : 0;
      return unit(u * m, v * m, Math.cos(t));
    },
  };
}

/**
 * Radial and tangential distortion of the plane z = 1, k1 k2 p1 p2 k3 [k4 k5 k6], and its inverse.
 * @param {number[]} d @param {number} end largest radius
 */
function brownConrady([k1, k2, p1, p2, k3, k4 = 0, k5 = 0, k6 = 0], end) {
  const above = (/** @type {number} */ s) => 1 + s * (k1 + s * (k2 + s * k3));
  const below = (/** @type {number} */ s) => 1 + s * (k4 + s * (k5 + s * k6));
  /** Of above / below, by s. @param {number} s */
  const growth = (s) => {
    const [n, m] = [above(s), below(s)];
    return ((k1 + s * (2 * k2 + s * 3 * k3)) * m - n * (k4 + s * (2 * k5 + s * 3 * k6))) / (m * m);
  };
  /** @type {Curve} */
  const curve = {
    at: (r) => (r * above(r * r)) / below(r * r),
    slope: (r) => (below(r * r) > 0 ? above(r * r) / below(r * r) + 2 * r * r * growth(r * r) : -1),
    end,
  };
  const inverse = invert(curve);

  /** @param {number} x @param {number} y @returns {[number, number]} */
  const bend = (x, y) => {
    const s = x * x + y * y;
    const radial = above(s) / below(s);
    return [x * radial + 2 * p1 * x * y + p2 * (s + 2 * x * x), y * radial + p1 * (s + 2 * y * y) + 2 * p2 * x * y];
  };

  return {
    end: inverse.end,
    /** @param {number} x @param {number} y */
    distort: (x, y) => (Math.sqrt(x * x + y * y) < inverse.end ? bend(x, y) : null),
    /**
     * Newton's method from the inverse of the radial part.
     * @param {number} u
     * @param {number} v
     * @returns {[number, number] | null}
     */
    undistort(u, v) {
      const length = Math.sqrt(u * u + v * v);
      // A little beyond the end is tried too: the tangential part moves the edge.
      const first = inverse.find(length) ?? (length < 1.05 * inverse.reach ? inverse.end : null);
      if (first === null) return null;
      let [x, y] = length > 0 ? [(u * first) / length, (v * first) / length] : [0, 0];
      for (let iteration = 0; iteration < MAX_ITERATIONS; iteration++) {
        const s = x * x + y * y;
        const [radial, slope] = [above(s) / below(s), 2 * growth(s)];
        const [a, b] = bend(x, y);
        const [ex, ey] = [a - u, b - v];
        const xx = radial + x * x * slope + 2 * p1 * y + 6 * p2 * x;
        const xy = x * y * slope + 2 * p1 * x + 2 * p2 * y;
        const yy = radial + y * y * slope + 6 * p1 * y + 2 * p2 * x;
        const determinant = xx * yy - xy * xy;
        if (!(determinant > 0)) return null;
        const [dx, dy] = [(yy * ex - xy * ey) / determinant, (xx * ey - xy * ex) / determinant];
        x -= dx;
        y -= dy;
        if (Math.abs(dx) + Math.abs(dy) < TOLERANCE * (1 + length)) return Math.sqrt(x * x + y * y) < inverse.end ? [x, y] : null;
      }
      return null;
    },
  };
}

/**
 * The inverse of a curve, up to where it first turns back.
 * @param {Curve} curve
 * @returns {{end: number, reach: number, find: (value: number) => number | null}} reach: the curve's value at its end
 */
function invert({ at, slope, end: last }) {
  // Dense near the axis, where the picture is, and still out to the end.
  const widest = Math.atan(last);
  const places = Array.from({ length: INVERSE_STEPS + 1 }, (_, step) => Math.min(last, Math.tan((widest * step) / INVERSE_STEPS)));
  const turn = places.findIndex((t) => slope(t) <= 0);
  const end = turn < 0 ? last : bisect((t) => slope(t) > 0, places[turn - 1], places[turn]);
  const grid = turn < 0 ? places : [...places.slice(0, turn), end];
  const values = grid.map(at);
  const reach = values[values.length - 1];
  return {
    end,
    reach,
    find(value) {
      if (!(value < reach)) return null;
      let [low, high] = [0, grid.length - 1];
      while (high - low > 1) {
        const middle = (low + high) >> 1;
        if (values[middle] > value) high = middle;
        else low = middle;
      }
      const part = (value - values[low]) / (values[high] - values[low]);
      let t = grid[low] + part * (grid[high] - grid[low]);
      for (let iteration = 0; iteration < MAX_ITERATIONS; iteration++) {
        // Kept where the table says it is: near the turn the slope vanishes and the step runs away.
        const next = Math.min(grid[high], Math.max(grid[low], t - (at(t) - value) / slope(t)));
        const step = Math.abs(next - t);
        t = next;
        if (step < TOLERANCE * (1 + t)) break;
      }
      return t;
    },
  };
}

/**
 * Point at which a predicate that holds at `low` ceases to, by bisection.
 * @param {(t: number) => boolean} holds
 * @param {number} low
 * @param {number} high
 */
function bisect(holds, low, high) {
  for (let iteration = 0; iteration < 60; iteration++) {
    const middle = (low + high) / 2;
    if (holds(middle)) low = middle;
    else high = middle;
  }
  return low;
}

/** @param {number} x @param {number} y @param {number} z @returns {[number, number, number]} */
function unit(x, y, z) {
  const length = Math.sqrt(x * x + y * y + z * z); // Math.hypot would take twice as long, for every pixel
  return [x / length, y / length, z / length];
}
