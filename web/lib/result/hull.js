// Convex hull of points in the picture, and hatching of what lies outside. Pure.

/** @typedef {readonly number[]} Point x, y */

/** @param {Point} o @param {Point} a @param {Point} b positive: b is on the right of the way from o to a, y down */
const turn = (o, a, b) => (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);

/**
 * Vertices of the convex hull, clockwise as seen, y down (Andrew's monotone chain).
 * @param {readonly Point[]} points
 * @returns {Point[]}
 */
export function convexHull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = (/** @type {readonly Point[]} */ ordered) => {
    /** @type {Point[]} */
    const chain = [];
    for (const point of ordered) {
      while (chain.length > 1 && turn(chain[chain.length - 2], chain[chain.length - 1], point) <= 0) chain.pop();
      chain.push(point);
    }
    return chain.slice(0, -1);
  };
  return sorted.length < 3 ? sorted : [...half(sorted), ...half(sorted.reverse())];
}

/**
 * Diagonal lines over a picture without what is inside a convex polygon.
 * @param {readonly Point[]} hull clockwise, y down; empty: nothing is inside
 * @param {readonly [number, number]} size
 * @param {number} step between the lines
 * @returns {[Point, Point][]} from and to
 */
export function hatching(hull, [width, height], step) {
  return Array.from({ length: Math.floor((width + height) / step) + 1 }, (_, index) => index * step).flatMap((sum) => {
    // On the line x + y = sum, from x = low to x = high.
    const [low, high] = [Math.max(0, sum - height), Math.min(width, sum)];
    let [enter, leave] = hull.length > 2 ? [low, high] : [high, high];
    hull.forEach((point, index) => {
      const at = (/** @type {number} */ x) => turn(point, hull[(index + 1) % hull.length], [x, sum - x]);
      const [side, rate] = [at(0), at(1) - at(0)];
      if (rate > 0) enter = Math.max(enter, -side / rate);
      else if (rate < 0) leave = Math.min(leave, -side / rate);
      else if (side < 0) enter = Infinity;
    });
    const parts =
      enter < leave
        ? [
            [low, enter],
            [leave, high],
          ]
        : [[low, high]];
    return parts
      .filter(([from, to]) => to - from > 1e-9)
      .map(
        ([from, to]) =>
          /** @type {[Point, Point]} */ ([
            [from, sum - from],
            [to, sum - to],
          ]),
      );
  });
}
