"""Shape of a board that is not as drawn: a bend, and a print that stretched.

A sheet of paper bends, and a printer feeds it a little too fast. Both are the same in all views of a capture,
so enough views tell them from the lens: five parameters beside the intrinsics (Strobl & Hirzinger, "More
accurate pinhole camera calibration with imperfect planar target", ICCV workshops 2011, free every point
instead). A prior that expects a flat board keeps them small where the views say nothing of them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .. import models
from ..arrays import Array
from ..errors import CalibrationError
from ..view import View
from . import normal_equations
from .calibration import Calibration
from .fit import refine
from .normal_equations import POSE_SIZE, Poses
from .observations import Observations

SHAPE_SIZE = 5
"""Parameters: height by x^2, xy and y^2; stretch of x against y; shear."""
HEIGHT_STD_BOARDS, STRETCH_STD = 0.005, 0.003
"""Standard deviations expected: of the height at the rim / longer side; of stretch and shear, as a share."""
MAX_SHAPE_STEPS = 8
MIN_SHAPE_DECREASE = 1e-6
"""Relative decrease of the cost below which the estimate is final."""


@dataclass(frozen=True)
class BoardShape:
    """Deviation of a board from its drawing.

    Attributes
    ----------
    center, half
        Middle of the corners (x, y) and half their longer extent, board units.
    reach
        Half the extent of the corners along x and y / the longer of them.
    parameters
        Heights of x^2, xy and y^2 where x and y are 1 at half a longer side from the middle, / longer extent;
        then the relative stretch of x (y shrinks by the same) and the shear of x by y.
    """

    center: tuple[float, float]
    half: float
    reach: tuple[float, float]
    parameters: tuple[float, ...] = (0.0,) * SHAPE_SIZE

    @classmethod
    def flat(cls, views: Sequence[View]) -> "BoardShape":
        """Shape of the board of some views, as drawn."""
        points = np.concatenate([view.object_points for view in views])
        low, high = points.min(axis=0), points.max(axis=0)
        x, y = ((low + high) / 2)[:2].tolist()
        width, height = (high - low)[:2].tolist()
        longer = max(width, height)
        return cls((x, y), longer / 2, (width / longer, height / longer))

    @property
    def sag(self) -> float:
        """Largest height over the plane that fits best / longer extent of the corners."""
        grid = np.linspace(-1, 1, 9)
        x, y = (c.ravel() for c in np.meshgrid(self.reach[0] * grid, self.reach[1] * grid))
        height = np.stack([x * x, x * y, y * y], axis=1) @ np.array(self.parameters[:3])
        plane = np.stack([x, y, np.ones_like(x)], axis=1)
        off = height - plane @ np.linalg.lstsq(plane, height, rcond=None)[0]
        return float(np.abs(off).max())

    @property
    def stretch(self) -> float:
        """Error of the print: the larger of stretch (width against height) and shear, as a share."""
        return max(2 * abs(self.parameters[3]), abs(self.parameters[4]))

    def displacements(self, points: Array) -> Array:
        """Differentiate points (3, ...), board frame, by the parameters: (SHAPE_SIZE, 3, ...)."""
        x = (points[0] - self.center[0]) / self.half
        y = (points[1] - self.center[1]) / self.half
        out = np.zeros((SHAPE_SIZE, *points.shape))
        out[0, 2], out[1, 2], out[2, 2] = x * x, x * y, y * y
        out[:3] *= 2 * self.half
        out[3, 0], out[3, 1], out[4, 0] = x * self.half, -y * self.half, y * self.half
        return out

    def apply(self, view: View) -> View:
        """Return the view of the board in this shape."""
        moved = np.tensordot(np.array(self.parameters), self.displacements(view.object_points.T), axes=1)
        return View(view.object_points + moved.T, view.image_points)


def estimate_board_shape(views: Sequence[View], calibration: Calibration) -> tuple[BoardShape, Calibration]:
    """Estimate the shape of the board that `views` share, and refine their calibration with it.

    Gauss-Newton steps of intrinsics, poses and shape together, poses eliminated, from the calibration on; the
    inliers of the calibration alone count. Raises CalibrationError as `refine` does.
    """
    shape = BoardShape.flat(views)
    camera, posed = calibration.camera, np.isfinite(calibration.poses).all(axis=1)
    kept = [i for i in np.flatnonzero(posed).tolist() if calibration.used[i].any()]
    seen = [views[i] for i in kept]
    obs = Observations.of(seen)
    mask = np.zeros_like(obs.mask)
    for row, i in enumerate(kept):
        mask[row, : len(views[i])] = calibration.used[i]
    model, k = models.get(camera.model), camera.intrinsics
    poses = Poses.of_vectors(np.array(calibration.poses)[kept])
    expected = np.array([HEIGHT_STD_BOARDS] * 3 + [STRETCH_STD] * 2)
    belief = np.diag((calibration.noise / expected) ** 2)
    by_shape = np.stack([shape.displacements(p) for p in obs.points], axis=2)  # (SHAPE_SIZE, 3, v, n)
    a = np.zeros(SHAPE_SIZE)
    best = np.inf
    for _ in range(MAX_SHAPE_STEPS):
        points = obs.points + np.einsum("s,sivn->vin", a, by_shape)
        q, rows = normal_equations.linearize(model, k, poses, points, 0)
        e = (q - obs.pixels.transpose(1, 0, 2)) * mask
        cost = float(np.sum(e**2) + a @ belief @ a)
        if not cost < best * (1 - MIN_SHAPE_DECREASE):
            break
        best = cost
        by_point = rows[model.size + 3 : model.size + POSE_SIZE]
        turned = np.einsum("vij,sjvn->sivn", poses.r, by_shape)
        free = np.einsum("iavn,sivn->savn", by_point, turned)
        full = np.concatenate([rows[: model.size], free, rows[model.size :], e[None]]) * mask
        dk, da, dp = _step(normal_equations.gram_matrices(full), model.size, belief, a)
        k, a, poses = k + dk, a + da, poses.retract(dp)
    shape = replace(shape, parameters=tuple(a.tolist()))
    if not np.isfinite(a).all():
        raise CalibrationError("not_converged", "the shape of the board does not settle")
    near = type(camera).from_intrinsics(camera.model, k, camera.img_size)
    vectors = np.array(calibration.poses)
    vectors[kept] = poses.vectors()
    return shape, refine([shape.apply(view) for view in views], near, vectors, planar=False)


def _step(h: Array, size: int, belief: Array, a: Array) -> tuple[Array, Array, Array]:
    """Solve for the steps of intrinsics (p,), shape (SHAPE_SIZE,) and poses (v, 6).

    Parameters
    ----------
    h
        (v, m, m) Gram matrices of the rows of intrinsics, shape, pose and residual.
    belief
        (SHAPE_SIZE, SHAPE_SIZE) information of the shape's prior, `a` (SHAPE_SIZE,) the shape so far.
    """
    free = size + SHAPE_SIZE
    pose, last = slice(free, free + POSE_SIZE), free + POSE_SIZE
    scale = 1 / np.sqrt(np.maximum(np.diagonal(h[:, pose, pose], axis1=1, axis2=2), 1e-300))
    unit = h[:, pose, pose] * scale[:, :, None] * scale[:, None, :]
    right = np.concatenate([h[:, pose, :free], h[:, pose, last:]], axis=2) * scale[:, :, None]
    solved = normal_equations.eliminate_poses(unit, right, 1e-12)
    taken = np.einsum("vij,vik->jk", right[:, :, :free], solved)
    s = h[:, :free, :free].sum(axis=0) - taken[:, :free]
    g = h[:, :free, last].sum(axis=0) - taken[:, free]
    s[size:, size:] += belief
    g[size:] += belief @ a
    d = 1 / np.sqrt(np.diagonal(s))
    step = -d * np.linalg.solve(s * d[:, None] * d + 1e-12 * np.eye(free), d * g)
    dp = -(solved[:, :, free] + solved[:, :, :free] @ step) * scale
    return step[:size], step[size:], dp
