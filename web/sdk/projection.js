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
 * @property {number} limit half-angle of the valid domain, radians: the cone about the axis on which the model is
 *   one-to-one
 *
 * @typedef {object} Curve how far from the axis a ray meets the plane of unit focal length, before tangential terms
 * @property {(t: number) => number} at
 * @property {(t: number) => number} slope
 * @property {number} end argument up to which it grows
 */

/** Names of the coefficients, in the order of `distortion_coefficients`. @type {Record<string, string[]>} */
export const COEFFICIENTS = {
  rectilinear: ["k1", "k2", "p1", "p2", "k3"],
  fisheye: ["k1", "k2", "k3", "k4"],
  rational: ["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"],
  omnidirectional: ["xi", "k1", "k2", "p1", "p2"],
};

/** Largest distance from the axis on the plane of unit focal length at which a planar model is used. */
const MAX_RADIUS = 50;
/**
 * Radial derivative over r |(p1, p2)| above which a planar model is one-to-one; see docs/conventions.md, "Valid
 * domain".
 */
const MIN_TANGENTIAL_RATIO = 7;
const INVERSE_STEPS = 512;
const TOLERANCE = 1e-13;
/** Step of Newton's method after which the next, about its square, would be rounding. */
const LAST_STEP = 1e-9;
/** Newton's method converges in four or five steps, except close to the edge of the domain. */
const MAX_ITERATIONS = 20;

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
  const cosine = Math.cos(limit);
  return {
    limit,
    project([x, y, z]) {
      if (!(z > cosine * Math.sqrt(x * x + y * y + z * z))) return null;
      const at = distort(x, y, z);
      return [fx * at[0] + cx, fy * at[1] + cy];
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

/** Rectilinear and rational; rectilinear has no denominator. @param {number[]} d */
function pinhole(d) {
  const brown = brownConrady(d, MAX_RADIUS);
  return {
    limit: Math.atan(brown.end),
    /** @param {number} x @param {number} y @param {number} z */
    distort: (x, y, z) => brown.distort(x / z, y / z),
    /** @param {number} u @param {number} v */
    undistort(u, v) {
      const at = brown.undistort(u, v);
      return at && unit(at[0], at[1], 1);
    },
  };
}

/** The unit sphere seen from xi behind its centre, then Brown's distortion without k3. @param {number[]} d */
function unified([xi, k1, k2, p1, p2]) {
  // Where xi > 1, the image radius sin t / (cos t + xi) of the sphere grows up to here.
  const { end, distort, undistort } = brownConrady(
    [k1, k2, p1, p2, 0],
    xi > 1 ? 1 / Math.sqrt(xi * xi - 1) : MAX_RADIUS,
  );
  /** Distance to the sphere along the ray (x, y, 1), in its units; s = x² + y². @param {number} s */
  const along = (s) => (xi + Math.sqrt(Math.max(1 + (1 - xi * xi) * s, 0))) / (1 + s);
  const atEnd = along(end * end);
  return {
    limit: xi > -1 ? Math.atan2(end * atEnd, atEnd - xi) : 0,
    /** @param {number} x @param {number} y @param {number} z */
    distort(x, y, z) {
      const depth = z + xi * Math.sqrt(x * x + y * y + z * z);
      return distort(x / depth, y / depth);
    },
    /** @param {number} u @param {number} v */
    undistort(u, v) {
      const at = undistort(u, v);
      if (!at) return null;
      const length = along(at[0] * at[0] + at[1] * at[1]);
      return unit(length * at[0], length * at[1], length - xi);
    },
  };
}

/** The image radius is a polynomial of the angle, which atan2 gives beyond 90° too. @param {number[]} d */
function kannalaBrandt([k1, k2, k3, k4]) {
  const inverse = invert({
    at: (t) => t * (1 + t * t * (k1 + t * t * (k2 + t * t * (k3 + t * t * k4)))),
    slope: (t) => 1 + t * t * (3 * k1 + t * t * (5 * k2 + t * t * (7 * k3 + t * t * 9 * k4))),
    end: Math.sqrt(firstRoot([1, 3 * k1, 5 * k2, 7 * k3, 9 * k4], Math.PI ** 2)),
  });
  return {
    limit: inverse.end,
    /** @param {number} x @param {number} y @param {number} z @returns {[number, number]} */
    distort(x, y, z) {
      const r = Math.hypot(x, y);
      const m = r > 0 ? inverse.at(Math.atan2(r, z)) / r : 0;
      return [x * m, y * m];
    },
    /** @param {number} u @param {number} v */
    undistort(u, v) {
      const r = Math.hypot(u, v);
      if (!(r < inverse.reach)) return null;
      const t = inverse.find(r);
      const m = r > 0 ? Math.sin(t) / r : 0;
      return unit(u * m, v * m, Math.cos(t));
    },
  };
}

/**
 * Radial and tangential distortion of the plane z = 1, k1 k2 p1 p2 k3 [k4 k5 k6], and its inverse.
 * @param {number[]} d @param {number} last largest radius
 */
function brownConrady([k1, k2, p1, p2, k3, k4 = 0, k5 = 0, k6 = 0], last) {
  const above = (/** @type {number} */ s) => 1 + s * (k1 + s * (k2 + s * k3));
  const below = (/** @type {number} */ s) => 1 + s * (k4 + s * (k5 + s * k6));
  /** Of above / below, by s. @param {number} s */
  const growth = (s) => {
    const [n, m] = [above(s), below(s)];
    return ((k1 + s * (2 * k2 + s * 3 * k3)) * m - n * (k4 + s * (2 * k5 + s * 3 * k6))) / (m * m);
  };
  const tangential = Math.hypot(p1, p2);
  const end = Math.min(last, domainRadius([1, k1, k2, k3], [1, k4, k5, k6], tangential));
  const inverse = invert({
    at: (r) => (r * above(r * r)) / below(r * r),
    slope: (r) => above(r * r) / below(r * r) + 2 * r * r * growth(r * r),
    end,
  });
  // The tangential part moves points by at most 3 P r². A pole at the end reaches everywhere.
  const reach = 1.01 * Math.abs(inverse.at(end)) + 3 * tangential * end * end;

  /** @param {number} x @param {number} y @returns {[number, number]} */
  const distort = (x, y) => {
    const s = x * x + y * y;
    const radial = above(s) / below(s);
    return [x * radial + 2 * p1 * x * y + p2 * (s + 2 * x * x), y * radial + p1 * (s + 2 * y * y) + 2 * p2 * x * y];
  };

  return {
    end,
    distort,
    /**
     * Newton's method from the inverse of the radial part.
     * @param {number} u
     * @param {number} v
     * @returns {[number, number] | null}
     */
    undistort(u, v) {
      const length = Math.sqrt(u * u + v * v);
      if (!(length < reach)) return null;
      const first = inverse.find(length);
      let [x, y] = length > 0 ? [(u * first) / length, (v * first) / length] : [0, 0];
      let [a, b] = distort(x, y);
      for (let iteration = 0; iteration < MAX_ITERATIONS; iteration++) {
        const s = x * x + y * y;
        const [radial, slope] = [above(s) / below(s), 2 * growth(s)];
        const [ex, ey] = [a - u, b - v];
        const xx = radial + x * x * slope + 2 * p1 * y + 6 * p2 * x;
        const xy = x * y * slope + 2 * p1 * x + 2 * p2 * y;
        const yy = radial + y * y * slope + 6 * p1 * y + 2 * p2 * x;
        const determinant = xx * yy - xy * xy;
        let [nextX, nextY] = [x - (yy * ex - xy * ey) / determinant, y - (xx * ey - xy * ex) / determinant];
        // A step across the edge ends before it: beyond, another ray may meet the same pixel.
        const back = (Math.sqrt(s) + 7 * end) / 8 / Math.sqrt(nextX * nextX + nextY * nextY);
        if (back < 1) [nextX, nextY] = [nextX * back, nextY * back];
        const step = Math.abs(nextX - x) + Math.abs(nextY - y);
        [x, y] = [nextX, nextY];
        [a, b] = distort(x, y);
        if (!(step > LAST_STEP)) break;
      }
      const [ex, ey] = [a - u, b - v];
      return Math.sqrt(ex * ex + ey * ey) < TOLERANCE * (1 + length) && Math.sqrt(x * x + y * y) < end ? [x, y] : null;
    },
  };
}

/**
 * Radius below which the denominator is positive and the radial derivative h > 7 r P: a polynomial of r once it is
 * multiplied by the denominator's square.
 * @param {number[]} above numerator of the radial factor, by s = r²
 * @param {number[]} below
 * @param {number} tangential P = |(p1, p2)|
 */
function domainRadius(above, below, tangential) {
  const polynomial = new Array(14).fill(0);
  above.forEach((n, i) => below.forEach((m, j) => (polynomial[2 * (i + j)] += n * m * (1 + 2 * i - 2 * j))));
  below.forEach((n, i) =>
    below.forEach((m, j) => (polynomial[2 * (i + j) + 1] -= MIN_TANGENTIAL_RATIO * tangential * n * m)),
  );
  return Math.min(firstRoot(polynomial, MAX_RADIUS), Math.sqrt(firstRoot(below, MAX_RADIUS ** 2)));
}

/**
 * Smallest root of a polynomial in (0, limit), its constant first; `limit` if there is none.
 * @param {number[]} polynomial
 * @param {number} limit
 */
function firstRoot(polynomial, limit) {
  return rootsBetween(polynomial, limit)[0] ?? limit;
}

/**
 * Roots in (0, limit) at which the polynomial changes its sign, by bisection between those of its derivative.
 * @param {number[]} polynomial
 * @param {number} limit
 * @returns {number[]}
 */
function rootsBetween(polynomial, limit) {
  const degree = polynomial.findLastIndex((c) => c !== 0);
  if (degree < 1) return [];
  const value = (/** @type {number} */ t) => polynomial.reduceRight((sum, c) => sum * t + c, 0);
  const turns = rootsBetween(
    polynomial.slice(1, degree + 1).map((c, i) => c * (i + 1)),
    limit,
  );
  return [...turns, limit].flatMap((high, i) => {
    const low = turns[i - 1] ?? 0;
    const isPositive = value(low) > 0;
    return value(high) > 0 === isPositive ? [] : [bisect((t) => value(t) > 0 === isPositive, low, high)];
  });
}

/**
 * The inverse of a curve that grows.
 * @param {Curve} curve
 * @returns {Curve & {reach: number, find: (value: number) => number}} reach: the curve's value at its end
 */
function invert({ at, slope, end }) {
  // Dense near the axis, where the picture is. Not at the end itself, where a rational model may have a pole.
  const grid = Array.from({ length: INVERSE_STEPS }, (_, step) => Math.tan((Math.atan(end) * step) / INVERSE_STEPS));
  const values = grid.map(at);
  return {
    at,
    slope,
    end,
    reach: at(end),
    find(value) {
      let [low, high] = [0, grid.length];
      while (high - low > 1) {
        const middle = (low + high) >> 1;
        if (values[middle] > value) high = middle;
        else low = middle;
      }
      let t = grid[low];
      for (let iteration = 0; iteration < MAX_ITERATIONS; iteration++) {
        // Kept where the table says it is: near the end the slope may vanish and the step run away.
        const next = Math.min(grid[high] ?? end, Math.max(grid[low], t - (at(t) - value) / slope(t)));
        const step = Math.abs(next - t);
        t = next;
        if (!(step > TOLERANCE * (1 + t))) break;
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
  for (;;) {
    const middle = (low + high) / 2;
    if (middle === low || middle === high) return low;
    if (holds(middle)) low = middle;
    else high = middle;
  }
}

/** @param {number} x @param {number} y @param {number} z @returns {[number, number, number]} */
function unit(x, y, z) {
  const length = Math.sqrt(x * x + y * y + z * z); // Math.hypot would take twice as long, for every pixel
  return [x / length, y / length, z / length];
}
