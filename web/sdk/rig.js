// Rigs: cameras that do not move against each other, calibrated together, and where they are.
//
//     import { rectifyPair, rig } from "https://<host>/sdk/calibdb.js";
//     const stereo = await rig(id, { token });
//     stereo.calibrations[1].project([0, 0, 1]); // as a lookup's
//     const pair = await rectifyPair(leftVideo, rightVideo, stereo);
import { Calibration } from "./calibration.js";
import { compose, invert, rigidMotion, rotationVectorOf, rowsOf } from "./motion.js";
import { ask, refusal } from "./request.js";
import { createViews } from "./views.js";

/**
 * @typedef {import("./calibration.js").CalibrationData} CalibrationData
 * @typedef {import("./motion.js").Motion} Motion
 * @typedef {import("./pair-rectifier.js").Source} Source
 * @typedef {import("./stereo.js").TwoCameras} TwoCameras
 * @typedef {import("./views.js").View} View
 * @typedef {import("./views.js").ViewOptions} ViewOptions
 *
 * @typedef {object} Extrinsics of a camera, from camera 0
 * @property {number} position of the camera in the rig, from 0
 * @property {number[]} rvec rotation vector, radians
 * @property {number[]} tvec in the rig's unit
 * @property {number[]} std six standard deviations: of rvec, radians, and of tvec, the rig's unit
 *
 * @typedef {object} RigData as the service answers it, and as its file `json` holds it
 * @property {string} rig_id
 * @property {string[]} cameras ids of the cameras' own calibrations, by position
 * @property {CalibrationData[]} calibrations as they were fitted together, by position
 * @property {Extrinsics[]} extrinsics by position; the first is 0
 * @property {"metres" | "squares"} unit of translations: squares of the board, if their size is unknown
 * @property {number} rms px, over all points of the capture
 * @property {number | null} held_out_rms px, of moments that took no part in the fit
 * @property {{rotation_deg: number, translation_percent: number, rms: number}} uncertainty expected turn of the
 *   camera that is known worst; expected shift in per cent of its distance from camera 0; rms error, px, of one
 *   camera's points in another
 * @property {{level: "good" | "fair" | "poor", reasons: string[]}} verdict "uncertain", "held_out" or "set_aside" are
 *   reasons
 * @property {(Motion & {moment: string})[]} [board_poses] boards of the moments that count: board → camera 0
 * @property {{sag: number, sag_std: number, stretch: number, stretch_std: number, stretch_kind?: "wider" | "narrower" |
 *   "skewed"}} [board_shape] bend and print of the board, shares of its longer side; missing: as drawn
 *
 * @typedef {object} Pose from a camera of a rig to another: x → R x + t, both frames x right, y down, z forward
 * @property {number[]} rvec rotation vector, radians
 * @property {number[]} tvec translation, the rig's unit
 * @property {number[][]} rotation R, row by row
 * @property {number[]} matrix R and t as 4x4, column-major as all matrices of WebGL
 * @property {number[] | null} std of rvec and tvec; null where neither camera is camera 0, from which they are known
 */

/** The service's answer, field by field, with calibrations that can do something. */
class Fields {
  /** @param {RigData} data */
  constructor(data) {
    Object.assign(this, data, { calibrations: data.calibrations.map((each) => new Calibration(each)) });
  }
}

const Data = /** @type {new (data: RigData) => Omit<RigData, "calibrations"> & {calibrations: Calibration[]}} */ (
  /** @type {unknown} */ (Fields)
);

/** A rig: its data, with functions. */
export class Rig extends Data {
  /**
   * @param {RigData} data an answer of the service, or the content of its file; throws a TypeError for something else
   */
  constructor(data) {
    const { calibrations, extrinsics } = data ?? {};
    const whole =
      Array.isArray(calibrations) &&
      Array.isArray(extrinsics) &&
      calibrations.length > 1 &&
      extrinsics.length === calibrations.length;
    if (!whole) throw new TypeError("this is no rig: calibrations and extrinsics of two or more cameras are needed");
    super(data);
  }

  /**
   * Pose from a camera to another.
   * @param {number} position of the camera to which it leads
   * @param {number} [from] position of the camera from which; 0 by default
   * @returns {Pose} throws a RangeError for a position that the rig has not
   */
  pose(position, from = 0) {
    const { r, t } = this.#motion(position, from);
    const matrix = [0, 1, 2].flatMap((column) => [r[column], r[column + 3], r[column + 6], 0]);
    const known = this.#extrinsics(position).std;
    return {
      rvec: rotationVectorOf(r),
      tvec: [...t],
      rotation: rowsOf(r),
      matrix: [...matrix, ...t, 1],
      std: from === 0 && known ? [...known] : null,
    };
  }

  /**
   * The same rig in metres.
   * @param {number} [squareSize] metres, side of a square of the board with which a rig in squares was captured
   * @returns {Rig} throws a TypeError if a rig in squares gets no size
   */
  toMetres(squareSize) {
    if (this.unit === "metres") return this;
    const size = Number(squareSize);
    if (!(size > 0))
      throw new TypeError("this rig is in squares of its board: say how large one is, in metres: toMetres(0.03)");
    const scaled = (/** @type {readonly number[]} */ vector) => vector.map((value) => value * size);
    const extrinsics = this.extrinsics.map(({ tvec, std, ...rest }) => ({
      ...rest,
      tvec: scaled(tvec),
      std: std && [...std.slice(0, 3), ...scaled(std.slice(3))],
    }));
    const boards = this.board_poses?.map(({ tvec, ...rest }) => ({ ...rest, tvec: scaled(tvec) }));
    return new Rig({ ...this, extrinsics, unit: "metres", ...(boards && { board_poses: boards }) });
  }

  /**
   * Views of two cameras as eyes, as WebXR has them, left one first whatever the positions. The world is the frame of
   * camera 0.
   * @param {ViewOptions & {positions?: readonly [number, number]}} [options] `positions` of the two cameras; [0, 1]
   *   by default
   * @returns {View[]}
   */
  views({ positions: [one, other] = [0, 1], ...options } = {}) {
    const eyes = invert(this.#motion(other, one)).t[0] < 0 ? [other, one] : [one, other];
    return createViews(
      eyes.map((position, index) => ({
        eye: index ? "right" : "left",
        pinhole: this.calibrations[position],
        motion: this.#motion(position, 0),
      })),
      options,
    );
  }

  /** @param {number} position @param {number} from */
  #motion(position, from) {
    const there = rigidMotion(this.#extrinsics(position));
    return from === 0 ? there : compose(there, invert(rigidMotion(this.#extrinsics(from))));
  }

  /** @param {number} position @returns {Extrinsics} */
  #extrinsics(position) {
    const found = this.extrinsics.find((each) => each.position === position);
    if (!found)
      throw new RangeError(`this rig has cameras 0 to ${this.calibrations.length - 1}, and no camera ${position}`);
    return found;
  }
}

/**
 * Reads a rig that was calibrated.
 * @param {string} id of the rig, as it stands in the address of its page, `/rig/?id=`
 * @param {import("./request.js").RequestOptions} options
 * @returns {Promise<Rig>} rejects with LookupError: where there is no such rig, or none that is finished, in the
 *   service's words
 */
export async function rig(id, options) {
  if (!/^[\w-]+$/.test(id ?? ""))
    throw new TypeError("say which rig: its id stands in the address of its page, /rig/?id=…");
  const { response, body } = await ask(`rigs/${id}/result`, {}, /** @type {any} */ (options ?? {}));
  if (!response.ok || !body.extrinsics) throw refusal(response, body);
  return new Rig(body);
}

/**
 * Rectifies pictures of two cameras on the GPU, so that a point lies in the same row of both, and its depth is
 * focal length × baseline / disparity. Of videos, call `draw()` once a frame.
 * @template {import("./warp.js").AnyCanvas} [Canvas=HTMLCanvasElement]
 * @param {Source} left
 * @param {Source} right pictures of the sizes of the calibrations; twice the same of a camera that delivers both in
 *   one, see the option `packing`
 * @param {Rig | TwoCameras} cameras
 * @param {import("./pair-rectifier.js").PairOptions<Canvas> & {positions?: readonly [number, number]}} [options]
 *   `positions` of left and right camera in the rig; [0, 1] by default
 * @returns {Promise<import("./pair-rectifier.js").PairRectifier<Canvas>>} with what is in the pictures now drawn;
 *   rejects with RectificationError where the cameras have no
 *   rectified pictures, with RectifierError where there is no WebGL2, with a TypeError for pictures of another shape
 * than the calibrations
 */
export async function rectifyPair(left, right, cameras, { positions: [one, other] = [0, 1], ...options } = {}) {
  const { PairRectifier } = await import("./pair-rectifier.js");
  // Not `instanceof`: the rig may come from another copy of these modules.
  const two =
    cameras && "calibrations" in cameras
      ? { left: cameras.calibrations[one], right: cameras.calibrations[other], pose: cameras.pose(other, one) }
      : cameras;
  if (!two?.left || !two.right || !two.pose)
    throw new TypeError("say which cameras these are: a rig, or { left, right, pose }");
  return new PairRectifier(left, right, two, options);
}
