// Image quality of a frame in a few numbers: exposure, sharpness, size of the squares, moiré. Cheap enough for every frame.
import { isBlack } from "./board.js";
import { squareSizes } from "./subpixel.js";

/**
 * @typedef {import("./subpixel.js").Grey} Grey
 * @typedef {import("./board.js").Board} Board
 *
 * @typedef {object} FrameMetrics
 * @property {number} median brightness, 0…255
 * @property {number} high brightness that 5 % of the picture exceed
 * @property {number} overexposed share of the picture that is saturated
 * @property {number | null} sharpness of the edges: about 0.2 in focus, 0.06 where they are 7 px wide; null where there are none
 * @property {number} square median side of the squares or, where no corner was found, of the markers, px; 0: none
 * @property {number | null} moire unevenness of the board's white, as a share of its contrast; null where no board is seen
 */

const SUBSAMPLING = 4; // every fourth pixel of every fourth row
const EDGE_SPAN = 4; // px: an edge in focus is narrower
const MIN_EDGE_CONTRAST = 32; // of 255 over the span: less is noise, or shading
const MIN_EDGE_PIXELS = 60;

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
  return { median: quantile(0.5), high: quantile(0.95), overexposed: (counts[255] + counts[254] + counts[253]) / total };
}

/**
 * Squared differences over one pixel, as a share of those over four: a step in one place gives 1/4, a long ramp 1/16.
 * Blur in any one direction lowers it across that direction; the lower of the two counts.
 * @param {Grey} image @param {number[][]} points corners of a board, about which to look; everywhere where there are none
 * @returns {number | null}
 */
export function sharpness({ width, height, data }, points) {
  const [left, top, right, bottom] = boundingBox(points, width, height);
  const ratios = [[1, width], [width, 1]].map(([along]) => {
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
  }).filter((ratio) => ratio !== null);
  return ratios.length ? Math.min(...ratios) : null;
}

/** @param {number[][]} points @param {number} width @param {number} height */
function boundingBox(points, width, height) {
  if (points.length < 6) return [0, 0, width - 1, height - 1];
  const [xs, ys] = [points.map(([x]) => x), points.map(([, y]) => y)];
  return [
    Math.max(0, Math.floor(Math.min(...xs))), Math.max(0, Math.floor(Math.min(...ys))),
    Math.min(width - 1, Math.ceil(Math.max(...xs))), Math.min(height - 1, Math.ceil(Math.max(...ys))),
  ];
}

/**
 * Unevenness of the white around the markers, square by square: the pixels of a filmed screen beat against the camera's.
 * @param {Grey} image @param {Board} board @param {{ids: number[], points: number[][]}} found
 * @returns {number | null} standard deviation, of the contrast between white and black; median over the squares
 */
export function moire(image, board, { ids, points }) {
  const [columns, rows] = board.squares;
  const place = new Map(ids.map((id, index) => [id, points[index]]));
  const ring = (1 - board.marker_ratio) / 4; // middle of the white around a marker
  /** @type {number[]} */
  const ratios = [];
  for (let y = 1; y < rows - 1; y++) {
    for (let x = 1; x < columns - 1; x++) {
      if (isBlack(board, x, y)) continue;
      const first = (y - 1) * (columns - 1) + x - 1;
      const quad = [first, first + 1, first + columns, first + columns - 1].map((id) => place.get(id));
      const [a, b, c, d] = quad;
      if (!a || !b || !c || !d || Math.hypot(b[0] - a[0], b[1] - a[1]) * ring < 2.5) continue;
      /** @param {number} u @param {number} v bilinear in the square */
      const at = (u, v) => [0, 1].map((k) => (1 - v) * ((1 - u) * a[k] + u * b[k]) + v * ((1 - u) * d[k] + u * c[k]));
      const white = along((s) => [at(s, ring), at(s, 1 - ring), at(ring, s), at(1 - ring, s)], image);
      const black = sample(image, at(0.5, -0.5)); // the middle of the black square above
      const mean = white.reduce((sum, value) => sum + value, 0) / white.length;
      if (mean - black < 2 * MIN_EDGE_CONTRAST / 3) continue;
      const variance = white.reduce((sum, value) => sum + (value - mean) ** 2, 0) / white.length;
      ratios.push(Math.sqrt(variance) / (mean - black));
    }
  }
  return ratios.length < 3 ? null : ratios.sort((p, q) => p - q)[ratios.length >> 1];
}

/** @param {(s: number) => number[][]} places @param {Grey} image */
function along(places, image) {
  return Array.from({ length: 9 }, (_, index) => 0.14 + 0.09 * index).flatMap(places).map((place) => sample(image, place));
}

/** @param {Grey} image @param {number[]} place px */
function sample({ width, height, data }, [x, y]) {
  const [column, row] = [Math.round(x), Math.round(y)];
  return data[Math.min(height - 1, Math.max(0, row)) * width + Math.min(width - 1, Math.max(0, column))];
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
    moire: moire(image, board, found),
  };
}
