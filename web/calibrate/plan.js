// Target poses while the service is away: a fixed plan of poses, drawn by the page itself.
import { corners, outline } from "../lib/board.js";
import { reach } from "../lib/network.js";
import { focalLengths } from "../sdk/pinhole.js";
import { isKnownModel, lensOf } from "../sdk/projection.js";
import { rotationMatrix, rotationVectorOf, transformPoint } from "../lib/pose.js";

/**
 * @import { Board } from "../lib/board.js"
 * @import { Pose } from "../lib/session.js"
 * @import { Intrinsics } from "../sdk/projection.js"
 */

/**
 * @typedef {{rvec: number[], tvec: number[], purpose: string, hint: string, hint_code?: string}} Step board → camera,
 *   squares
 */

/** Camera and board of the plan: a camera of 0.8 image widths, in landscape, and our own board. */
const FOCAL = 0.8;
const MADE_FOR = /** @type {[number, number]} */ ([9, 6]);

/** @returns {Promise<Step[]>} none where there is no plan: it is a comfort, and no capture fails for it */
export async function loadPlan() {
  const response = await reach(new URL("./plan.json", import.meta.url));
  return response.ok ? response.json() : [];
}

/** Views from which an estimate may tell where the board is seen: one of two can be wild. */
const MIN_TRUSTED_VIEWS = 3;
/** Part of the board's corners that a target must have in the picture. */
const IN_SIGHT = 0.6;

/**
 * Known lens of the camera, as far as targets can be drawn with it.
 * @param {{calibration: Intrinsics | null, views: {set_aside?: object | null}[]} | null} session
 */
export function trustedCalibration(session) {
  return session && session.views.filter(({ set_aside }) => !set_aside).length >= MIN_TRUSTED_VIEWS
    ? session.calibration
    : null;
}

/**
 * The next step of the plan that can be drawn whole: a lens of strong distortion sees none of what is far from its
 * axis.
 * Where it can draw none of them, they are drawn as by the camera that the plan was made for.
 * @param {Step[]} plan @param {number} from step to try first @param {Board} board @param {[number, number]} size px
 * @param {Intrinsics | null} known
 * @returns {{pose: Pose, next: number} | null} next: the step after it; null where there is no plan
 */
export function nextPlanned(plan, from, board, size, known) {
  for (const camera of known && isKnownModel(known.distortion_model) ? [known, null] : [null]) {
    for (let tried = 0; tried < plan.length; tried++) {
      const step = (from + tried) % plan.length;
      const pose = plannedPose(plan[step], board, size, camera);
      if (pose) return { pose, next: step + 1 };
    }
  }
  return null;
}

/**
 * A step of the plan for this board and this camera.
 * @param {Step} step @param {Board} board @param {[number, number]} size of the image, px
 * @param {Intrinsics | null} known null: no view has been fitted yet
 * @returns {Pose | null} with the index −1: it answers no pose of the service; null where its outline cannot be drawn
 */
export function plannedPose(step, board, size, known) {
  const longer = Math.max(...size);
  const [fx] = focalLengths(known ?? pinhole(size));
  const larger = (Math.hypot(...board.squares) / Math.hypot(...MADE_FOR)) * (fx / (FOCAL * longer));
  const upright = size[0] < size[1];
  const turned = upright ? quarterTurn(step) : step;
  // The board's middle stays where the plan has it, in the picture; its size there as well.
  const centre = transformPoint(turned, [MADE_FOR[0] / 2, MADE_FOR[1] / 2, 0]).map(
    (value, axis) => value * larger * (axis < 2 ? (FOCAL * longer) / fx : 1),
  );
  const half = transformPoint({ rvec: turned.rvec, tvec: [0, 0, 0] }, [board.squares[0] / 2, board.squares[1] / 2, 0]);
  const pose = { rvec: turned.rvec, tvec: centre.map((value, axis) => value - half[axis]) };
  const lens = lensOf(known ?? pinhole(size));
  const project = (/** @type {number[]} */ [x, y]) => lens.project(transformPoint(pose, [x, y, 0]));
  /** @type {number[]} */
  const ids = [];
  /** @type {[number, number][]} */
  const seen = [];
  corners(board).forEach((point, id) => {
    const q = project(point);
    if (!q || q[0] < 0 || q[1] < 0 || q[0] > size[0] - 1 || q[1] > size[1] - 1) return;
    ids.push(id);
    seen.push(q);
  });
  const edge = outline(board)
    .map(project)
    .filter((q) => q !== null);
  if (edge.length < 4 || ids.length < IN_SIGHT * corners(board).length) return null;
  return /** @type {Pose} */ ({
    index: -1,
    ...pose,
    ids,
    corners: seen,
    outline: edge,
    purpose: step.purpose,
    hint: step.hint,
    hint_code: step.hint_code ?? "first",
  });
}

/** The camera that the plan supposes. @param {[number, number]} size @returns {Intrinsics} */
function pinhole([width, height]) {
  const f = FOCAL * Math.max(width, height);
  return {
    camera_matrix: [
      [f, 0, (width - 1) / 2],
      [0, f, (height - 1) / 2],
      [0, 0, 1],
    ],
    distortion_coefficients: [0, 0, 0, 0, 0],
    distortion_model: "rectilinear",
  };
}

/** The same pose before a camera held upright. @param {Step} step */
function quarterTurn({ rvec, tvec: [x, y, z] }) {
  const [a, b, c, d, e, f, g, h, i] = rotationMatrix(rvec);
  return { rvec: rotationVectorOf([-d, -e, -f, a, b, c, g, h, i]), tvec: [-y, x, z] };
}
