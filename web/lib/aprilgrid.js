// AprilGrid in an image: its tags' corners, numbered as Kalibr numbers them. Pure.
import { DEFAULT_TAG_SPACING } from "./board.js";
import { apply, homography } from "./homography.js";
import { centreOf, sideOf } from "./marker-detector.js";
import { median } from "./marker-grid.js";
import { refineCorner } from "./subpixel.js";

/**
 * @import { Board } from "./board.js"
 * @import { Homography } from "./homography.js"
 * @import { Marker } from "./marker-detector.js"
 * @import { Grey } from "./subpixel.js"
 */

const MIN_GRID_TAGS = 3; // fewer do not show how the tags are rotated on the grid
const MAX_TAG_MISS = 0.5; // sides of a tag: a tag farther from its place is not part of this board
const GAP_WINDOW_SHARE = 0.35; // of the gap: half the window of the refinement, which must not hold the next tag
const [MIN_GAP_WINDOW_PX, MAX_GAP_WINDOW_PX] = [2, 6];
const MAX_SHIFT = 0.12; // sides of a tag: a larger refinement means that the detected corner was wrong

/**
 * Corners of an AprilGrid. Tags may be turned on it, as Kalibr's are: which corner is which follows from the grid.
 * @param {Grey} image @param {Board} board @param {Marker[]} markers of its family
 * @param {boolean} [every] the corners at the board's edge, too, where others are surer: a guided capture plans with
 *   the whole board
 * @returns {{ids: number[], points: number[][]}}
 */
export function aprilgridCorners(
  image,
  { squares: [columns, rows], tag_spacing: spacing = DEFAULT_TAG_SPACING },
  markers,
  every = false,
) {
  const pitch = 1 + spacing;
  const corner = (/** @type {number} */ tag) => [(tag % columns) * pitch, -Math.floor(tag / columns) * pitch];
  const centre = (/** @type {Marker} */ { id }) => [corner(id)[0] + 0.5, corner(id)[1] - 0.5];
  let tags = markers.filter(({ id }) => id < columns * rows);
  /** @type {Homography | null} */
  let h = null;
  for (let more = tags.length > MIN_GRID_TAGS; more;) {
    h = homography(tags.map(centre), tags.map(centreOf));
    const errors = tags.map((tag) => {
      const [x, y] = h ? apply(h, centre(tag)) : [NaN, NaN];
      const [u, v] = centreOf(tag);
      return Math.hypot(x - u, y - v) / sideOf(tag);
    });
    const worst = errors.indexOf(Math.max(...errors));
    more = errors[worst] > MAX_TAG_MISS && tags.length > MIN_GRID_TAGS + 1;
    if (errors[worst] > MAX_TAG_MISS) tags = tags.filter((_, n) => n !== worst);
  }
  const turn = h ? commonTurn(tags, h, corner) : 0;
  /** @type {{id: number, point: number[], saddle: boolean}[]} */
  const all = [];
  for (const tag of tags) {
    const side = sideOf(tag);
    const half = Math.round(
      Math.min(MAX_GAP_WINDOW_PX, Math.max(MIN_GAP_WINDOW_PX, GAP_WINDOW_SHARE * spacing * side)),
    );
    for (let n = 0; n < 4; n++) {
      // The detector names corners clockwise from the upper left, Kalibr anticlockwise from the lower left.
      const [x, y] = tag.corners[(3 - n + turn) % 4];
      const better = refineCorner(image, x, y, half);
      if (!better || Math.hypot(better[0] - x, better[1] - y) > Math.max(1.5, MAX_SHIFT * side)) continue;
      all.push({ id: 4 * tag.id + n, point: better, saddle: isSaddle(image, better, centreOf(tag), spacing) });
    }
  }
  // If black squares lie in the gaps, a corner without one is less certain than the others: blur moves it inwards.
  const saddles = all.filter(({ saddle }) => saddle);
  const kept = !every && 2 * saddles.length > all.length ? saddles : all;
  return { ids: kept.map(({ id }) => id), points: kept.map(({ point }) => point) };
}

/**
 * True if a black square of the gap touches a tag's corner.
 * @param {Grey} image
 * @param {number[]} corner px
 * @param {number[]} centre of the tag, px
 * @param {number} spacing
 */
function isSaddle({ width, height, data }, [x, y], [u, v], spacing) {
  const sample = (/** @type {number} */ dx, /** @type {number} */ dy) =>
    data[
      Math.min(height - 1, Math.max(0, Math.round(y + dy))) * width +
        Math.min(width - 1, Math.max(0, Math.round(x + dx)))
    ];
  const [dx, dy] = [(x - u) * 0.8 * spacing, (y - v) * 0.8 * spacing];
  const [outside, inside] = [sample(dx, dy), sample(-0.12 * (x - u), -0.12 * (y - v))];
  const white = (sample(-dy, dx) + sample(dy, -dx)) / 2;
  return Math.abs(outside - inside) < Math.abs(outside - white);
}

/**
 * Quarter turns of the tags on the grid, by the vote of all.
 * @param {Marker[]} tags
 * @param {Homography} h
 * @param {(tag: number) => number[]} corner
 */
function commonTurn(tags, h, corner) {
  const votes = [0, 0, 0, 0];
  for (const tag of tags) {
    const [x, y] = corner(tag.id);
    const [u, v] = apply(h, [x, y]);
    const distances = tag.corners.map(([a, b]) => Math.hypot(a - u, b - v));
    votes[(distances.indexOf(Math.min(...distances)) + 1) % 4] += 1; // its own lower left is corner 3
  }
  return votes.indexOf(Math.max(...votes));
}

/** Typical side of the tags, px; 0 where there are none. @param {Marker[]} markers */
export const typicalSide = (markers) => (markers.length ? median(markers.map(sideOf)) : 0);
