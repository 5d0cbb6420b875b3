"""The result of a rig's fit."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ..arrays import Array
from ..camera import Camera
from ..fitting.board_shape import BoardShape
from .problem import Moment


@dataclass(frozen=True)
class RigUncertainty:
    """Predicted error of a rig.

    Attributes
    ----------
    rotation_deg
        Degrees, expected turn of the camera that is known worst against camera 0.
    translation_percent
        Expected shift of a camera / its distance from camera 0, per cent, of the camera known worst.
    rms
        px, rms distance between points of one camera, at working distance, and where the rig projects them in
        another.
    """

    rotation_deg: float
    translation_percent: float
    rms: float


@dataclass(frozen=True, eq=False)
class RigCalibration:
    """Cameras that do not move against each other, and how well their moments are explained.

    Attributes
    ----------
    cameras
        Model, intrinsics, image size, by position.
    poses
        (c, 6) rvec|tvec, camera 0 -> camera i; the first is 0. Units of the moments' object points.
    board_poses
        (m, 6) rvec|tvec, board -> camera 0; NaN of a moment of which no view could be used.
    rms
        px, root of the mean square distance over all points given, but for those of views set aside.
    view_errors
        px, rms of each view under the rig, by (moment, position); also of views set aside.
    covariance
        (q, q) of the intrinsics of each camera (fx fy cx cy distortion...; 0 where they are held), then of
        the poses of cameras 1, 2, ...; moments are the clusters (`fitting.robust_covariance`).
    noise
        px, standard deviation of one coordinate of a corner: the geometric mean of the cameras'.
    inflation
        Variance that the rig sees / variance that white noise of the corners gives it, >= 1.
    uncertainty
        Predicted error.
    working_distances
        (c,) median distance of each camera from the board's points that it and another camera saw.
    set_aside
        (moment, position) -> why the view took no part: ``outlier``, ``mirrored``, ``degenerate``,
        ``contradicts`` the rig.
    turned
        (moment, position) of the views whose corners were numbered from another side of the board, and were
        turned back. `board_poses` hold for the boards turned back.
    board_shape
        Bend and stretch of the board, which the errors and board poses refer to; None: as drawn.
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
        """Return moments of the same board in its shape."""
        if self.board_shape is None:
            return list(moments)
        return [{i: self.board_shape.apply(view) for i, view in moment.items()} for moment in moments]

    def pose_covariance(self, position: int) -> Array:
        """Covariance (6, 6) of the pose rvec|tvec of one camera; 0 of camera 0."""
        first = sum(len(camera.intrinsics) for camera in self.cameras) + 6 * (position - 1)
        part = slice(first, first + 6)
        return self.covariance[part, part] if position else self.covariance[:6, :6] * 0
