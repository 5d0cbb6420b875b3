// Board to which the markers of a picture belong: ids and places fit the rows and columns of one only. Pure.
import { centreOf, sideOf } from "./marker-detector.js";
import { apply, homography } from "./homography.js";

/** @import { Marker } from "./marker-detector.js" */

/**
 * @typedef {object} Hypothesis
 * @property {"charuco" | "aprilgrid"} kind
 * @property {number} columns of squares, or tags
 * @property {boolean} markerFirst whether the first square of a ChArUco board holds a marker, as OpenCV before 4.6 drew
 *   some
 *
 * @typedef {Hypothesis & {error: number, inliers: Marker[], side: number}} GridFit error: median distance of a marker
 *   from where the hypothesis has it, of its side; side: of a marker, in squares (charuco) or distances of tags
 *   (aprilgrid)
 */

const MAX_SQUARES = 50; // a side
const MIN_MARKERS = 4;
const MIN_INLIER_SHARE = 0.6;
const MAX_ERROR = 0.2; // sides of a marker: a lens bends a board by no more
const MIN_ERROR_RATIO = 2.5; // by which every other hypothesis must be worse
const MAX_OUTLIER_ERROR = 0.6; // sides of a marker

/**
 * Column and row of the square in which a marker lies; of a tag, from below.
 * @param {Hypothesis} hypothesis
 * @param {number} id
 * @returns {[number, number]}
 */
export function squareOf({ kind, columns, markerFirst }, id) {
  if (kind === "aprilgrid") return [id % columns, Math.floor(id / columns)];
  // Two rows together hold `columns` markers; the first of them those of its odd squares, or of its even ones.
  const inFirst = markerFirst ? Math.ceil(columns / 2) : Math.floor(columns / 2);
  const [pair, rest] = [Math.floor(id / columns), id % columns];
  const first = rest < inFirst;
  return [2 * (first ? rest : rest - inFirst) + (first === markerFirst ? 0 : 1), 2 * pair + (first ? 0 : 1)];
}

/** Centre of a marker on the board, y down. @param {Hypothesis} hypothesis @param {number} id */
function placeOf(hypothesis, id) {
  const [x, y] = squareOf(hypothesis, id);
  return hypothesis.kind === "aprilgrid" ? [x + 0.5, -y - 0.5] : [x + 0.5, y + 0.5];
}

/**
 * The board whose rows and columns the markers fit.
 * @param {Marker[]} markers of one picture @param {boolean} isTagFamily whether they may be those of an AprilGrid
 * @returns {GridFit | null} null where none fits, or several do
 */
export function fitGrid(markers, isTagFamily) {
  if (markers.length < MIN_MARKERS) return null;
  /** @type {Hypothesis[]} */
  const hypotheses = [];
  for (let columns = 3; columns <= MAX_SQUARES; columns++)
    for (const markerFirst of [false, true]) hypotheses.push({ kind: "charuco", columns, markerFirst });
  if (isTagFamily)
    for (let columns = 1; columns <= MAX_SQUARES; columns++)
      hypotheses.push({ kind: "aprilgrid", columns, markerFirst: true });
  const fits = hypotheses
    .map((hypothesis) => fit(hypothesis, markers))
    .filter((found) => found !== null)
    .filter(({ error }) => error < MAX_ERROR);
  // Without the ends of its rows a board looks like one that begins a column later.
  fits.sort((a, b) => b.inliers.length - a.inliers.length || a.error - b.error);
  const [best, next] = fits;
  if (!best) return null;
  return next &&
    next.inliers.length === best.inliers.length &&
    next.error < MIN_ERROR_RATIO * Math.max(best.error, 0.02)
    ? null
    : best;
}

/** @param {Hypothesis} hypothesis @param {Marker[]} markers @returns {GridFit | null} */
function fit(hypothesis, markers) {
  let inliers = markers.filter(({ id }) => squareOf(hypothesis, id)[1] < MAX_SQUARES);
  for (let round = 0; round < 8; round++) {
    if (inliers.length < Math.max(MIN_MARKERS, MIN_INLIER_SHARE * markers.length)) return null;
    const places = inliers.map(({ id }) => placeOf(hypothesis, id));
    if (isLine(places)) return null;
    const centres = inliers.map(centreOf);
    const h = homography(places, centres);
    if (!h) return null;
    const errors = inliers.map((marker, n) => {
      const [x, y] = apply(h, places[n]);
      return Math.hypot(x - centres[n][0], y - centres[n][1]) / sideOf(marker);
    });
    const worst = errors.indexOf(Math.max(...errors));
    if (!(errors[worst] > MAX_OUTLIER_ERROR)) return turned(hypothesis, inliers, places, median(errors));
    inliers = inliers.filter((_, n) => n !== worst);
  }
  return null;
}

/**
 * The fit, if markers lie on the board as they must: not mirrored, and ChArUco's upright.
 * @param {Hypothesis} hypothesis
 * @param {Marker[]} inliers
 * @param {number[][]} places
 * @param {number} error
 * @returns {GridFit | null}
 */
function turned(hypothesis, inliers, places, error) {
  const back = homography(inliers.map(centreOf), places);
  if (!back) return null;
  const shapes = inliers.map(({ corners }) => corners.map((corner) => apply(back, corner)));
  const area = (/** @type {number[][]} */ [a, b, c]) => (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]);
  if (!shapes.every((shape) => area(shape) > 0)) return null;
  const upright = shapes.filter(([[x1, y1], [x2, y2]]) => x2 - x1 > Math.abs(y2 - y1)).length;
  if (hypothesis.kind === "charuco" && upright < 0.8 * shapes.length) return null;
  const side = median(shapes.map((corners, n) => sideOf({ id: inliers[n].id, corners })));
  return side > 0.2 && side < 1 ? { ...hypothesis, error, inliers, side } : null;
}

/** True if places lie in one row, column or diagonal: no homography follows. @param {number[][]} places */
function isLine(places) {
  const [mx, my] = [0, 1].map((axis) => places.reduce((sum, place) => sum + place[axis], 0) / places.length);
  let [xx, xy, yy] = [0, 0, 0];
  for (const [x, y] of places) [xx, xy, yy] = [xx + (x - mx) ** 2, xy + (x - mx) * (y - my), yy + (y - my) ** 2];
  return xx * yy - xy * xy < 1e-6 * (xx + yy) ** 2 || Math.min(xx, yy) === 0;
}

/** @param {number[]} values */
export const median = (values) => [...values].sort((a, b) => a - b)[values.length >> 1] ?? NaN;
