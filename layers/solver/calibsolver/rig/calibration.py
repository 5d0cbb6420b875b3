"""The result of a rig's fit."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..camera import Camera
from ..fitting.board_shape import BoardShape
from .problem import Moment
from .start import RigidMotion


@dataclass(frozen=True)
class RigUncertainty:
    """Predicted error of a rig.

    Turn against camera 0 and shift / distance from it of the camera that is known worst; px, rms distance
    between points of one camera, at working distance, and where the rig projects them in another.
    """

    rotation_deg: float
    translation_percent: float
    rms: float


@dataclass(frozen=True, eq=False)
class RigCalibration:
    """Result of a rig's fit.

    Attributes
    ----------
    poses
        (c, 6) rvec|tvec, camera 0 -> camera i, board units.
    board_poses
        (m, 6) rvec|tvec, board (turned back if it was `turned`) -> camera 0; NaN without a usable view.
    rms
        px, over all points of the views that are not set aside.
    view_errors
        px, rms of each view under the rig, by (moment, position); also of views set aside.
    covariance
        (q, q) of the intrinsics of each camera (0 if held), then of the poses of cameras 1, 2, ...; the
        moments are the clusters (`fitting.robust_covariance`).
    noise
        px, standard deviation of one coordinate of a corner: the geometric mean of the cameras'.
    inflation
        Variance that the rig sees / variance that white noise of the corners gives it, >= 1.
    working_distances
        (c,) as `transfer.working_distances`.
    set_aside
        (moment, position) -> ``outlier``, ``mirrored``, ``degenerate``, or ``contradicts`` the rig.
    turned
        (moment, position) of the views whose corners were numbered from another side of the board.
    board_shape
        Bend and stretch of the board, to which errors and board poses refer; None: as drawn.
    """

    cameras: tuple[Camera, ...]
    poses: Array
    board_poses: Array
    rms: float
    view_errors: Mapping[tuple[int, int], float]
    covariance: Array
    noise: float
    inflation: float
    uncertainty: RigUncertainty
    working_distances: Array
    set_aside: Mapping[tuple[int, int], str]
    turned: tuple[tuple[int, int], ...] = ()
    board_shape: BoardShape | None = None

    def shaped(self, moments: Sequence[Moment]) -> list[Moment]:
        """Moments of the same board in its shape."""
        if self.board_shape is None:
            return list(moments)
        return [{i: self.board_shape.apply(view) for i, view in moment.items()} for moment in moments]

    @property
    def motions(self) -> list[RigidMotion]:
        """Poses of the cameras as motions."""
        return [RigidMotion.of_vector(pose) for pose in self.poses]

    def intrinsics_covariance(self, position: int) -> Array:
        """Covariance (p, p) of the intrinsics of one camera."""
        sizes = [len(camera.intrinsics) for camera in self.cameras]
        first = sum(sizes[:position])
        part = slice(first, first + sizes[position])
        return self.covariance[part, part]

    def pose_covariance(self, position: int) -> Array:
        """Covariance (6, 6) of the pose rvec|tvec of one camera; 0 of camera 0."""
        first = sum(len(camera.intrinsics) for camera in self.cameras) + 6 * (position - 1)
        part = slice(first, first + 6)
        return self.covariance[part, part] if position else np.zeros((6, 6))
