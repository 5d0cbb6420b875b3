// Rectification of two cameras: both turned so that epipolar lines are rows, or columns.
//
// Bouguet's algorithm as OpenCV has it (Hartley & Zisserman, "Multiple View Geometry", 11.12), for every camera
// model: each camera is turned by half of the rotation between them, then both so that the baseline lies along an
// axis of the picture. The service's files have the same numbers.
import {
  compose,
  multiply,
  rigidMotion,
  rotate,
  rotationMatrix,
  rotationVectorOf,
  rowsOf,
  transpose,
} from "./motion.js";
import { focalLengths } from "./pinhole.js";
import { lensOf } from "./projection.js";

/**
 * @typedef {import("./rectification.js").Calibration} Calibration
 * @typedef {import("./motion.js").Motion} Motion
 * @typedef {import("./motion.js").RigidMotion} RigidMotion
 *
 * @typedef {object} Rectification as `cv.stereoRectify` returns it; all matrices row by row
 * @property {[number, number]} img_size of both rectified pictures, px
 * @property {number[][]} R1 rotation 3x3, left camera → its rectified frame
 * @property {number[][]} R2 rotation 3x3, right camera → its rectified frame
 * @property {number[][]} P1 3x4, rectified frame of the left camera → px of the left picture
 * @property {number[][]} P2 3x4, rectified frame of the left camera → px of the right picture
 * @property {number[][]} Q 4x4, (u, v, disparity, 1) of the left picture → homogeneous point, rectified frame of the
 *   left camera
 * @property {number} focal px, along both axes of both pictures
 * @property {number} baseline in the unit of the pose; depth = focal * baseline / disparity. Negative where the right
 *   picture's camera stands on the left, or above: disparities are, too
 * @property {boolean} isVertical whether one camera is above the other: disparities are along y, then
 *
 * @typedef {object} TwoCameras
 * @property {Calibration} left
 * @property {Calibration} right
 * @property {Motion} pose left camera → right camera
 *
 * @typedef {object} Layout
 * @property {number} [scale] of the rectified pictures to the left camera's, 1 by default: a half costs a quarter
 * @property {number} [zoom] how much larger things are shown in pictures of the same size, 1 by default
 */

const RIM_SAMPLES = 9; // places along each edge of a picture that are looked at
const MIN_DEPTH = 0.2; // of a unit ray in the rectified frame
const MIN_SEEN = 0.75; // share of the rim's rays that have such a depth

/** Two cameras have no rectified pictures. */
export class RectificationError extends RangeError {
  /** @param {string} message */
  constructor(message) {
    super(message);
    this.name = "RectificationError";
  }
}

/**
 * Rectify two cameras.
 * @param {Calibration} left @param {Calibration} right @param {Motion} pose left camera → right camera
 * @param {Layout} [layout]
 * @returns {Rectification} throws RectificationError where the cameras are in one place, or look in directions too far
 *   apart;
 *   UnknownModelError
 */
export function rectify(left, right, pose, { scale = 1, zoom = 1 } = {}) {
  const { r, t } = rigidMotion(pose);
  const length = Math.hypot(...t);
  if (!(length > 0))
    throw new RectificationError("cameras in one place have no rectified pictures: their pose has no translation");
  const half = rotationMatrix(rotationVectorOf(r).map((value) => -value / 2));
  const middle = rotate(half, t);
  const axis = Math.abs(middle[1]) > Math.abs(middle[0]) ? 1 : 0;
  const turn = ontoAxis(middle, axis, length);
  const [r1, r2] = [multiply(turn, transpose(half)), multiply(turn, half)];
  const shift = rotate(turn, middle)[axis];
  const cameras = [left, right];
  const own = Math.min(...cameras.map((camera) => focalLengths(camera)[1 - axis])) * zoom;
  const [a, b] = [centre(left, r1), centre(right, r2)];
  // As of the picture's full size, then scaled: the centre of the top-left pixel stays (0, 0).
  const at = left.img_size.map((side, each) => (side - 1) / 2 - (own * (a[each] + b[each])) / 2);
  const focal = own * scale;
  const [cx, cy] = at.map((value) => (value + 0.5) * scale - 0.5);
  const [width, height] = left.img_size.map((side) => Math.max(1, Math.round(side * scale)));
  const P1 = [
    [focal, 0, cx, 0],
    [0, focal, cy, 0],
    [0, 0, 1, 0],
  ];
  const P2 = P1.map((row, each) => (each === axis ? [...row.slice(0, 3), focal * shift] : [...row]));
  const Q = [
    [1, 0, 0, -cx],
    [0, 1, 0, -cy],
    [0, 0, 0, focal],
    [0, 0, -1 / shift, 0],
  ];
  return {
    img_size: [width, height],
    R1: rowsOf(r1),
    R2: rowsOf(r2),
    P1,
    P2,
    Q,
    focal,
    baseline: -shift,
    isVertical: axis === 1,
  };
}

/**
 * Frames of both rectified cameras.
 * @param {Rectification} rectification @param {Motion} pose left camera → right camera
 * @returns {[RigidMotion, RigidMotion]} left camera → rectified frame of the left, and of the right camera
 */
export function rectifiedMotions({ R1, R2 }, pose) {
  const still = [0, 0, 0];
  return [{ r: R1.flat(), t: still }, compose({ r: R2.flat(), t: still }, rigidMotion(pose))];
}

/**
 * Shortest rotation that lays a vector along an axis, in its sense.
 * @param {readonly number[]} v @param {number} axis @param {number} length of v
 */
function ontoAxis(v, axis, length) {
  const [x, y, z] = v;
  const sign = v[axis] > 0 ? 1 : -1;
  const across = axis === 1 ? [-z * sign, 0, x * sign] : [0, z * sign, -y * sign];
  const sine = Math.hypot(...across);
  const angle = Math.acos(Math.min(1, Math.abs(v[axis]) / length));
  return rotationMatrix(sine > 0 ? across.map((value) => (value * angle) / sine) : [0, 0, 0]);
}

/**
 * Mean of the rectified picture's rim, for unit focal length.
 * @param {Calibration} camera @param {readonly number[]} r camera → rectified frame
 * @returns {number[]}
 */
function centre(camera, r) {
  const {
    img_size: [width, height],
  } = camera;
  const lens = lensOf(camera);
  const onto = (/** @type {readonly [number, number]} */ pixel) => {
    const ray = lens.unproject([...pixel]);
    const [x, y, z] = ray ? rotate(r, ray) : [0, 0, -1];
    return z > MIN_DEPTH ? [x / z, y / z] : null;
  };
  const middle = onto([(width - 1) / 2, (height - 1) / 2]);
  if (!middle) throw new RectificationError("the cameras look in directions too far apart for rectified pictures");
  const places = Array.from({ length: RIM_SAMPLES }, (_, step) => step / (RIM_SAMPLES - 1));
  const rim = places.flatMap((y) =>
    places.filter((x) => x % 1 === 0 || y % 1 === 0).map((x) => onto([x * (width - 1), y * (height - 1)])),
  );
  const seen = rim.filter((place) => place !== null);
  // Of a wide lens the middle says where its picture is.
  if (seen.length < MIN_SEEN * rim.length) return middle;
  return [0, 1].map((each) => seen.reduce((sum, place) => sum + place[each], 0) / seen.length);
}
