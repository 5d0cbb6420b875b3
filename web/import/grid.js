// Recognition of the board and its corners in imported views. Pure.
//
// A file names its points by where they lie on the board, in whatever unit; a session by the corners' numbers.

/**
 * @typedef {object} View
 * @property {string} name
 * @property {number[][]} object where the points lie on the board: x, y, z
 * @property {number[][]} image where they were seen, px; the centre of the top-left pixel is (0, 0)
 *
 * @typedef {{name: string, ids: number[], points: number[][]}} Numbered
 *
 * @typedef {object} Grid
 * @property {[number, number]} squares columns and rows of a board that has these corners
 * @property {Numbered[]} views
 */

/** Error for a file that cannot be used; its code names a message. */
export class MalformedError extends Error {
  /** @param {string} code of a sentence: "import.wrong_…" @param {Record<string, string | number>} [values] in it */
  constructor(code, values = {}) {
    super([code, ...Object.entries(values).map(([name, value]) => `${name}=${value}`)].join(" "));
    this.name = "MalformedError";
    this.code = code;
    this.values = values;
  }
}

const OFF = 0.02; // squares by which a point may lie off its corner
const MAX_SIDE_SQUARES = 64; // squares on a side of a board
const MIN_BOARD_CORNERS = 6; // of a board

/**
 * @param {View[]} views
 * @returns {Grid} throws MalformedError where the points are not those of a flat board of squares
 */
export function grid(views) {
  const upwards = faces(views) < 0;
  const upright = upwards
    ? views.map((view) => ({ ...view, object: view.object.map(([x, y, z]) => [x, -y, z]) }))
    : views;
  const points = upright.flatMap(({ object }) => object);
  const [x, y, z] = [0, 1, 2].map((axis) => distinct(points.map((point) => point[axis])));
  if (x.length < 2 || y.length < 2) throw new MalformedError("line");
  const unit = Math.min(step(x), step(y));
  if (span(z) > OFF * unit) throw new MalformedError("flat");
  const [columns, rows] = [x, y].map((axis) => Math.round(span(axis) / unit) + 1);
  if (Math.max(columns, rows) >= MAX_SIDE_SQUARES || columns * rows < MIN_BOARD_CORNERS)
    throw new MalformedError("board", { columns, rows });
  return {
    squares: [columns + 1, rows + 1],
    views: upright.map(({ name, object, image }) => {
      const ids = object.map(([u, v]) => {
        const [column, row] = [(u - x[0]) / unit, (v - y[0]) / unit];
        const [across, down] = [Math.round(column), Math.round(row)];
        if (Math.max(Math.abs(column - across), Math.abs(row - down)) > OFF) throw new MalformedError("rows");
        return down * columns + across;
      });
      if (new Set(ids).size !== ids.length) throw new MalformedError("twice", { name });
      return { name, ids, points: image };
    }),
  };
}

/**
 * On which side of the board the views say that they are: more in front +, more behind −. The picture of a board whose
 * rows are counted upwards looks like its back.
 * @param {View[]} views
 */
const faces = (views) => views.reduce((sum, view) => sum + Math.sign(handedness(view)), 0);

/** Determinant of the affine map from board to picture, times a positive number. @param {View} view */
function handedness({ object, image }) {
  const [p, q] = [centred(object), centred(image)];
  const sum = (
    /** @type {number[][]} */ a,
    /** @type {number} */ i,
    /** @type {number[][]} */ b,
    /** @type {number} */ j,
  ) => a.reduce((total, point, index) => total + point[i] * b[index][j], 0);
  // Least squares: (Σ q pᵀ)(Σ p pᵀ)⁻¹; the second has a positive determinant, so the first one's sign is the map's.
  return sum(q, 0, p, 0) * sum(q, 1, p, 1) - sum(q, 0, p, 1) * sum(q, 1, p, 0);
}

/** @param {number[][]} points */
function centred(points) {
  const [x, y] = [0, 1].map((axis) => points.reduce((sum, point) => sum + point[axis], 0) / points.length);
  return points.map((point) => [point[0] - x, point[1] - y]);
}

/** The different values in order. @param {number[]} values */
function distinct(values) {
  const sorted = Float64Array.from(values).sort();
  const reach = Math.max(sorted[sorted.length - 1] - sorted[0], 1e-12);
  return sorted.filter((value, index) => index === 0 || value - sorted[index - 1] > 1e-6 * reach);
}

/** @param {Float64Array} axis */
const span = (axis) => axis[axis.length - 1] - axis[0];

/** The smallest distance of neighbours. @param {Float64Array} axis */
const step = (axis) => axis.slice(1).reduce((least, value, index) => Math.min(least, value - axis[index]), Infinity);
