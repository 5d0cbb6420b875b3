// Contours of values on a grid over the picture: bands between levels, and the value at any place. Pure.

/** @typedef {(number | null)[][]} Values rows of values, each at the centre of its cell; null: unknown */

/**
 * Values with a border, and where they lie: the outermost values extend to the picture's edge.
 * @param {Values} values @param {[number, number]} size px
 */
function bordered(values, [width, height]) {
  const places = (/** @type {number} */ count, /** @type {number} */ side) => [
    -0.5,
    ...Array.from({ length: count }, (_, index) => ((index + 0.5) * side) / count - 0.5),
    side - 0.5,
  ];
  const widen = (/** @type {any[]} */ line) => [line[0], ...line, line[line.length - 1]];
  return { x: places(values[0].length, width), y: places(values.length, height), at: widen(values.map(widen)) };
}

/**
 * Polygons of what is at least a level: of each cell between four values its part, straight between crossings.
 * @param {Values} values @param {[number, number]} size px @param {number} level
 * @returns {[number, number][][]} px
 */
export function above(values, size, level) {
  const { x, y, at } = bordered(values, size);
  /** @type {[number, number][][]} */
  const found = [];
  for (let row = 0; row + 1 < y.length; row++) {
    /** @type {[number, number][] | null} */
    let run = null; // whole cells side by side are one polygon
    for (let column = 0; column + 1 < x.length; column++) {
      const corners = /** @type {[number, number, number | null][]} */ ([
        [x[column], y[row], at[row][column]],
        [x[column + 1], y[row], at[row][column + 1]],
        [x[column + 1], y[row + 1], at[row + 1][column + 1]],
        [x[column], y[row + 1], at[row + 1][column]],
      ]);
      const whole = corners.every(([, , value]) => value !== null && value >= level);
      if (whole && run) {
        run[1] = [x[column + 1], y[row]];
        run[2] = [x[column + 1], y[row + 1]];
        continue;
      }
      run = null;
      if (corners.some(([, , value]) => value === null)) continue;
      const part = clip(/** @type {[number, number, number][]} */ (corners), level);
      if (part.length > 2) found.push(part);
      if (whole) run = part;
    }
  }
  return found;
}

/** @param {[number, number, number][]} corners in order @param {number} level @returns {[number, number][]} */
function clip(corners, level) {
  return corners.flatMap(([x, y, value], index) => {
    const [p, q, next] = corners[(index + 1) % corners.length];
    /** @type {[number, number][]} */
    const kept = value >= level ? [[x, y]] : [];
    if (value >= level === next >= level) return kept;
    const share = (level - value) / (next - value);
    return [...kept, /** @type {[number, number]} */ ([x + share * (p - x), y + share * (q - y)])];
  });
}

/**
 * The value at a place of the picture, linear between the values around it.
 * @param {Values} values @param {[number, number]} size px @param {[number, number]} place px
 * @returns {number | null} null: unknown
 */
export function valueAt(values, size, [u, v]) {
  const { x, y, at } = bordered(values, size);
  const [column, s] = between(x, u);
  const [row, r] = between(y, v);
  const corners = [at[row][column], at[row][column + 1], at[row + 1][column], at[row + 1][column + 1]];
  if (corners.some((value) => value === null)) return null;
  const [a, b, c, d] = /** @type {number[]} */ (corners);
  return (1 - r) * ((1 - s) * a + s * b) + r * ((1 - s) * c + s * d);
}

/**
 * @param {number[]} places
 * @param {number} value
 * @returns {[number, number]} index before it, and the share of the way to the next
 */
function between(places, value) {
  const index = Math.min(
    places.length - 2,
    Math.max(
      0,
      places.findLastIndex((place) => place <= value),
    ),
  );
  return [index, Math.min(1, Math.max(0, (value - places[index]) / (places[index + 1] - places[index])))];
}

/**
 * The same values on a finer grid, smooth through the values that there are (Catmull and Rom's splines).
 * @param {Values} values @param {number} factor of rows and columns
 * @returns {Values} null next to a value that is unknown
 */
export function refined(values, factor) {
  const turned = (/** @type {Values} */ rows) => rows[0].map((_, column) => rows.map((row) => row[column]));
  const along = (/** @type {Values} */ rows) =>
    rows.map((row) =>
      Array.from({ length: row.length * factor }, (_, index) => {
        const place = Math.min(row.length - 1, Math.max(0, (index + 0.5) / factor - 0.5));
        const first = Math.min(Math.floor(place), Math.max(0, row.length - 2));
        const [a, b, c, d] = [-1, 0, 1, 2].map((step) => row[Math.min(row.length - 1, Math.max(0, first + step))]);
        if (b === null || c === null) return null;
        const [before, after, s] = [a ?? b, d ?? c, place - first];
        return (
          b + 0.5 * s * (c - before + s * (2 * before - 5 * b + 4 * c - after + s * (3 * (b - c) + after - before)))
        );
      }),
    );
  return turned(along(turned(along(values))));
}
