// Pose of a board that is held so that it covers a drawn target. A person matches outlines, not numbers: the target may
// have been drawn for another lens.
import { corners as boardCorners } from "../board.js";
import { projectionOf } from "./lens.js";
import { minimize } from "../least-squares.js";
import { transformPoint } from "../pose.js";

/**
 * @import { Pose } from "../pose.js"
 * @import { LensParameters } from "./lens.js"
 */

const UNSEEN_RESIDUAL_PX = 1e3; // px, residual of a corner that the lens does not see
const MAX_CORNERS = 12; // corners; more would say the same, slower

/**
 * The pose in which this lens sees the board's corners nearest to where they are asked for.
 * @param {import("../board.js").Board} board @param {LensParameters} lens
 * @param {Pose & {ids?: readonly number[], corners?: readonly (readonly number[])[]}} target
 * @returns {Pose} the target's own where it shows too little of the board
 */
export function matchPose(board, lens, { rvec, tvec, ids = [], corners = [] }) {
  if (ids.length < 6) return { rvec, tvec };
  const { project } = projectionOf(lens);
  const places = boardCorners(board);
  const every = Math.max(1, Math.floor(ids.length / MAX_CORNERS));
  const used = ids.map((_, index) => index).filter((index) => index % every === 0 || index === ids.length - 1);
  const points = used.map((index) => [...places[ids[index]], 0]);
  /** @param {number[]} parameters */
  const residuals = (parameters) => {
    const pose = { rvec: parameters.slice(0, 3), tvec: parameters.slice(3) };
    return points.flatMap((point, n) => {
      const index = used[n];
      const p = transformPoint(pose, point);
      const pixel = p[2] < 0.1 ? null : project(p);
      return pixel
        ? [pixel[0] - corners[index][0], pixel[1] - corners[index][1]]
        : [UNSEEN_RESIDUAL_PX, UNSEEN_RESIDUAL_PX];
    });
  };
  const at = minimize(residuals, [...rvec, ...tvec]);
  return { rvec: at.slice(0, 3), tvec: at.slice(3) };
}
