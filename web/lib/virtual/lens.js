// A pinhole with OpenCV's rectilinear distortion (k1 k2 p1 p2 k3), both ways.

/**
 * @typedef {object} Lens
 * @property {number} fx px
 * @property {number} fy
 * @property {number} cx px, centre of the top-left pixel is 0
 * @property {number} cy
 * @property {number} k1
 * @property {number} k2
 * @property {number} p1
 * @property {number} p2
 * @property {number} k3
 */

/**
 * Distorts a point of the plane z = 1. Brown (1971), as in cv::projectPoints.
 * @param {Lens} lens @param {number} x @param {number} y
 * @returns {[number, number]}
 */
export function distort({ k1, k2, k3, p1, p2 }, x, y) {
  const r2 = x * x + y * y;
  const radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return [
    x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
    y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
  ];
}

/** @param {Lens} lens @param {number[]} point camera frame, z > 0 @returns {[number, number]} px */
export function project(lens, [x, y, z]) {
  const [u, v] = distort(lens, x / z, y / z);
  return [lens.fx * u + lens.cx, lens.fy * v + lens.cy];
}

/**
 * The point of the plane z = 1 that is seen at a pixel.
 *
 * Newton's method from the distorted point with the exact Jacobian. Where distortion folds the image over there is no
 * such point: a step that runs away from the axis, or a Jacobian that turns over, says so.
 * @param {Lens} lens @param {number} u px @param {number} v px
 * @returns {[number, number] | null}
 */
export function unproject(lens, u, v) {
  const { k1, k2, k3, p1, p2 } = lens;
  const [xd, yd] = [(u - lens.cx) / lens.fx, (v - lens.cy) / lens.fy];
  let [x, y] = [xd, yd];
  for (let iteration = 0; iteration < 30; iteration++) {
    const r2 = x * x + y * y;
    const radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
    const slope = 2 * (k1 + r2 * (2 * k2 + r2 * 3 * k3)); // d radial / d r² · 2
    const ex = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x) - xd;
    const ey = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y - yd;
    const a = radial + x * x * slope + 2 * p1 * y + 6 * p2 * x;
    const b = x * y * slope + 2 * p1 * x + 2 * p2 * y;
    const d = radial + y * y * slope + 6 * p1 * y + 2 * p2 * x;
    const determinant = a * d - b * b;
    if (determinant <= 0 || r2 > 25) return null;
    const [dx, dy] = [(d * ex - b * ey) / determinant, (a * ey - b * ex) / determinant];
    x -= dx;
    y -= dy;
    if (dx * dx + dy * dy < 1e-18) return [x, y];
  }
  return null;
}
