// What a frame looks like, in a few numbers: exposure, sharpness, size of the squares, stripes. Cheap: every frame pays.
import { isBlack } from "../board/geometry.js";
import { squareSizes } from "./subpixel.js";

/**
 * @typedef {import("./subpixel.js").Grey} Grey
 * @typedef {import("../board/geometry.js").Board} Board
 *
 * @typedef {object} Signs
 * @property {number} middle median brightness, 0…255
 * @property {number} high brightness that 5 % of the picture exceed
 * @property {number} burnt share of the picture that is as white as can be
 * @property {number | null} sharpness of the edges: about 0.2 in focus, 0.06 where they are 7 px wide; null where there are none
 * @property {number} square median side of the squares or, where no corner was found, of the markers, px; 0: none
 * @property {number | null} stripes in what should be evenly white, of the board's contrast; null where no board is seen
 */

const STEP = 4; // every fourth pixel of every fourth row
const SPAN = 4; // px: an edge in focus is narrower
const EDGE = 32; // of 255 over the span: less is noise, or shading
const FEWEST = 60; // places with an edge

/** @param {Grey} image @returns {Pick<Signs, "middle" | "high" | "burnt">} */
export function exposure({ width, height, data }) {
  const counts = new Uint32Array(256);
  let total = 0;
  for (let y = 0; y < height; y += STEP) {
    for (let at = y * width; at < (y + 1) * width; at += STEP, total++) counts[data[at]] += 1;
  }
  const below = (/** @type {number} */ share) => {
    let [sum, value] = [0, 0];
    while (value < 255 && (sum += counts[value]) < share * total) value += 1;
    return value;
  };
  return { middle: below(0.5), high: below(0.95), burnt: (counts[255] + counts[254] + counts[253]) / total };
}

/**
 * Squared differences over one pixel, as a share of those over four: a step in one place gives 1/4, a long ramp 1/16.
 * Blur in any one direction lowers it across that direction; the lower of the two counts.
 * @param {Grey} image @param {number[][]} points corners of a board, about which to look; everywhere where there are none
 * @returns {number | null}
 */
export function sharpness({ width, height, data }, points) {
  const [left, top, right, bottom] = around(points, width, height);
  const ratios = [[1, width], [width, 1]].map(([along]) => {
    const [stepX, stepY] = along === 1 ? [1, 2 * STEP] : [2 * STEP, 1];
    let [near, far, places] = [0, 0, 0];
    for (let y = top; y < bottom - SPAN; y += stepY) {
      for (let x = left; x < right - SPAN; x += stepX) {
        const at = y * width + x;
        const wide = data[at + SPAN * along] - data[at];
        if (wide < EDGE && wide > -EDGE) continue;
        const narrow = data[at + along] - data[at];
        near += narrow * narrow;
        far += wide * wide;
        places += 1;
      }
    }
    return places < FEWEST ? null : near / far;
  }).filter((ratio) => ratio !== null);
  return ratios.length ? Math.min(...ratios) : null;
}

/** @param {number[][]} points @param {number} width @param {number} height */
function around(points, width, height) {
  if (points.length < 6) return [0, 0, width - 1, height - 1];
  const [xs, ys] = [points.map(([x]) => x), points.map(([, y]) => y)];
  return [
    Math.max(0, Math.floor(Math.min(...xs))), Math.max(0, Math.floor(Math.min(...ys))),
    Math.min(width - 1, Math.ceil(Math.max(...xs))), Math.min(height - 1, Math.ceil(Math.max(...ys))),
  ];
}

/**
 * How uneven the white around the markers is, square by square. A screen filmed by a camera beats against its pixels.
 * @param {Grey} image @param {Board} board @param {{ids: number[], points: number[][]}} found
 * @returns {number | null} standard deviation, of the contrast between white and black; median over the squares
 */
export function stripes(image, board, { ids, points }) {
  const [columns, rows] = board.squares;
  const place = new Map(ids.map((id, index) => [id, points[index]]));
  const ring = (1 - board.marker_ratio) / 4; // middle of the white around a marker
  /** @type {number[]} */
  const uneven = [];
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
      if (mean - black < 2 * EDGE / 3) continue;
      const variance = white.reduce((sum, value) => sum + (value - mean) ** 2, 0) / white.length;
      uneven.push(Math.sqrt(variance) / (mean - black));
    }
  }
  return uneven.length < 3 ? null : uneven.sort((p, q) => p - q)[uneven.length >> 1];
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
 * @returns {Signs}
 */
export function signsOf(image, board, found, markerSide) {
  const sizes = squareSizes(found.ids, found.points, board.squares[0] - 1).sort((a, b) => a - b);
  return {
    ...exposure(image),
    sharpness: sharpness(image, found.points),
    square: sizes[sizes.length >> 1] || markerSide / board.marker_ratio,
    stripes: stripes(image, board, found),
  };
}
