// Image quality of a frame in a few numbers: exposure, sharpness, size of the squares, moiré. Cheap enough for every
// frame.
import { corners, isBlack } from "./board.js";
import { squareSizes } from "./subpixel.js";

/**
 * @import { Board } from "./board.js"
 * @import { Grey } from "./subpixel.js"
 */

/**
 * @typedef {object} FrameMetrics
 * @property {number} median brightness, 0…255
 * @property {number} high brightness that 5 % of the picture exceed
 * @property {number} overexposed share of the picture that is saturated
 * @property {number | null} sharpness of the edges: about 0.2 in focus, 0.06 where they are 7 px wide; null where there
 *   are none
 * @property {number} square median side of the squares or, where no corner was found, of the markers, px; 0: none
 * @property {number} share of the board's corners that were found, 0…1
 * @property {number | null} moire unevenness of the board's bright squares, as a share of their contrast; null where
 *   none is seen
 */

const SUBSAMPLING = 4; // every fourth pixel of every fourth row
const EDGE_SPAN = 4; // px: an edge in focus is narrower
const MIN_EDGE_CONTRAST = 32; // of 255 over the span: less is noise, or shading
const MIN_EDGE_PIXELS = 60;
const LINE_PLACES = Array.from({ length: 9 }, (_, index) => 0.14 + 0.09 * index); // along a line through a square
const MIN_FRAME_PX = 2; // from a square's edge to the middle of the plain frame: nearer, edges are smeared over it
const MIN_MOIRE_CONTRAST = 20; // of 255 between bright and dark: less is noise

/** @param {Grey} image @returns {Pick<FrameMetrics, "median" | "high" | "overexposed">} */
export function exposure({ width, height, data }) {
  const counts = new Uint32Array(256);
  let total = 0;
  for (let y = 0; y < height; y += SUBSAMPLING) {
    for (let at = y * width; at < (y + 1) * width; at += SUBSAMPLING, total++) counts[data[at]] += 1;
  }
  const quantile = (/** @type {number} */ share) => {
    let [sum, value] = [0, 0];
    while (value < 255 && (sum += counts[value]) < share * total) value += 1;
    return value;
  };
  return {
    median: quantile(0.5),
    high: quantile(0.95),
    overexposed: (counts[255] + counts[254] + counts[253]) / total,
  };
}

/**
 * Squared differences over one pixel, as a share of those over four: a step in one place gives 1/4, a long ramp 1/16.
 * Blur in any one direction lowers it across that direction; the lower of the two counts.
 * @param {Grey} image
 * @param {number[][]} points corners of a board, about which to look; everywhere where there are none
 * @returns {number | null}
 */
export function sharpness({ width, height, data }, points) {
  const [left, top, right, bottom] = boundingBox(points, width, height);
  const ratios = [
    [1, width],
    [width, 1],
  ]
    .map(([along]) => {
      const [stepX, stepY] = along === 1 ? [1, 2 * SUBSAMPLING] : [2 * SUBSAMPLING, 1];
      let [near, far, places] = [0, 0, 0];
      for (let y = top; y < bottom - EDGE_SPAN; y += stepY) {
        for (let x = left; x < right - EDGE_SPAN; x += stepX) {
          const at = y * width + x;
          const wide = data[at + EDGE_SPAN * along] - data[at];
          if (wide < MIN_EDGE_CONTRAST && wide > -MIN_EDGE_CONTRAST) continue;
          const narrow = data[at + along] - data[at];
          near += narrow * narrow;
          far += wide * wide;
          places += 1;
        }
      }
      return places < MIN_EDGE_PIXELS ? null : near / far;
    })
    .filter((ratio) => ratio !== null);
  return ratios.length ? Math.min(...ratios) : null;
}

/** @param {number[][]} points @param {number} width @param {number} height */
function boundingBox(points, width, height) {
  if (points.length < 6) return [0, 0, width - 1, height - 1];
  const [xs, ys] = [points.map(([x]) => x), points.map(([, y]) => y)];
  return [
    Math.max(0, Math.floor(Math.min(...xs))),
    Math.max(0, Math.floor(Math.min(...ys))),
    Math.min(width - 1, Math.ceil(Math.max(...xs))),
    Math.min(height - 1, Math.ceil(Math.max(...ys))),
  ];
}

/**
 * Unevenness of the squares that are bright in the picture: the pixels of a filmed screen beat against the camera's.
 * Dark print reflects the room, which is not a stripe; shading is taken out line by line.
 * @param {Grey} image @param {Board} board @param {{ids: number[], points: number[][]}} found
 * @returns {number | null} standard deviation along lines, of the contrast between bright and dark; median over the
 *   squares
 */
export function moire(image, board, { ids, points }) {
  const [columns, rows] = board.squares;
  const place = new Map(ids.map((id, index) => [id, points[index]]));
  const ring = (1 - board.marker_ratio) / 4; // middle of the plain frame around a marker
  // Bright squares with a marker are plain near their edges; those without, which an inverted board has, everywhere.
  const [offsets, dark] = board.inverted ? [[0.2, 0.5, 0.8], -ring] : [[ring, 1 - ring], -0.5];
  /** @type {number[]} */
  const ratios = [];
  for (let y = 1; y < rows - 1; y++) {
    for (let x = 1; x < columns - 1; x++) {
      if (isBlack(board, x, y) !== Boolean(board.inverted)) continue;
      const first = (y - 1) * (columns - 1) + x - 1;
      const quad = completed([first, first + 1, first + columns, first + columns - 1].map((id) => place.get(id)));
      if (!quad || shortestSide(quad) * ring < MIN_FRAME_PX) continue;
      const [a, b, c, d] = quad;
      /** @param {number} u @param {number} v bilinear in the square */
      const at = (u, v) =>
        sample(
          image,
          [0, 1].map((k) => (1 - v) * ((1 - u) * a[k] + u * b[k]) + v * ((1 - u) * d[k] + u * c[k])),
        );
      const lines = offsets.flatMap((offset) => [
        LINE_PLACES.map((s) => at(s, offset)),
        LINE_PLACES.map((s) => at(offset, s)),
      ]);
      const values = lines.flat();
      const contrast = values.reduce((sum, value) => sum + value, 0) / values.length - at(0.5, dark);
      if (contrast < MIN_MOIRE_CONTRAST) continue;
      const squares = lines.reduce((sum, line) => sum + squaresAboutSlope(line), 0);
      ratios.push(Math.sqrt(squares / (values.length - 2 * lines.length)) / contrast);
    }
  }
  return ratios.length === 0 ? null : ratios.sort((p, q) => p - q)[ratios.length >> 1];
}

/**
 * Four corners of a square; of three the fourth follows.
 * @param {(number[] | undefined)[]} quad
 * @returns {number[][] | null}
 */
function completed(quad) {
  const missing = quad.findIndex((corner) => !corner);
  if (missing < 0) return /** @type {number[][]} */ (quad);
  const [next, opposite, last] = [1, 2, 3].map((step) => quad[(missing + step) % 4]);
  if (!next || !opposite || !last) return null;
  return /** @type {number[][]} */ (
    quad.with(
      missing,
      [0, 1].map((k) => next[k] + last[k] - opposite[k]),
    )
  );
}

/** @param {number[][]} quad */
const shortestSide = (quad) =>
  Math.min(...quad.map(([x, y], n) => Math.hypot(quad[(n + 1) % 4][0] - x, quad[(n + 1) % 4][1] - y)));

/** Squared differences from the straight line that fits evenly spaced values best. @param {number[]} values */
function squaresAboutSlope(values) {
  const middle = (values.length - 1) / 2;
  const mean = values.reduce((sum, value) => sum + value, 0) / values.length;
  const spread = values.reduce((sum, _, n) => sum + (n - middle) ** 2, 0);
  const slope = values.reduce((sum, value, n) => sum + value * (n - middle), 0) / spread;
  return values.reduce((sum, value, n) => sum + (value - mean - slope * (n - middle)) ** 2, 0);
}

/** Brightness between pixels. @param {Grey} image @param {number[]} place px */
function sample({ width, height, data }, [x, y]) {
  const [left, top] = [
    Math.min(width - 2, Math.max(0, Math.floor(x))),
    Math.min(height - 2, Math.max(0, Math.floor(y))),
  ];
  const [u, v] = [Math.min(1, Math.max(0, x - left)), Math.min(1, Math.max(0, y - top))];
  const at = top * width + left;
  const upper = data[at] + u * (data[at + 1] - data[at]);
  return upper + v * (data[at + width] + u * (data[at + width + 1] - data[at + width]) - upper);
}

/**
 * @param {Grey} image @param {Board} board @param {{ids: number[], points: number[][]}} found
 * @param {number} markerSide median side of the markers found, px; 0: none
 * @returns {FrameMetrics}
 */
export function frameMetrics(image, board, found, markerSide) {
  const sizes = squareSizes(found.ids, found.points, board.squares[0] - 1).sort((a, b) => a - b);
  return {
    ...exposure(image),
    sharpness: sharpness(image, found.points),
    square: sizes[sizes.length >> 1] || markerSide / board.marker_ratio,
    share: found.ids.length / corners(board).length,
    moire: moire(image, board, found),
  };
}
