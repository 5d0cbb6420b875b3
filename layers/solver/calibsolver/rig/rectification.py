"""Rectification of two cameras: both turned so that epipolar lines are rows, or columns.

Bouguet's algorithm as in OpenCV (Hartley & Zisserman, "Multiple View Geometry", 11.12): each camera is
turned by half of the rotation between them, then both so that the baseline lies along an axis of the
image.
"""

from dataclasses import dataclass

import numpy as np

from .. import rotation
from ..arrays import Array
from ..camera import Camera
from ..errors import CalibrationError
from .start import RigidMotion

RIM_SAMPLES = 9


@dataclass(frozen=True, eq=False)
class Rectification:
    """Rotations and projections of a rectified pair, as cv2.stereoRectify returns them.

    Attributes
    ----------
    r1, r2
        (3, 3) camera frame -> rectified frame.
    p1, p2
        (3, 4) rectified frame of camera 0 -> pixels, both of the first image's size.
    q
        (4, 4) (x, y, disparity, 1) -> homogeneous point.
    is_vertical
        True if the baseline, and with it disparities, lies along y.
    """

    r1: Array
    r2: Array
    p1: Array
    p2: Array
    q: Array
    is_vertical: bool


def rectify(one: Camera, other: Camera, motion: RigidMotion) -> Rectification:
    """Rectify two cameras, `motion` camera `one` -> camera `other`.

    Focal length: the smaller of the two. The principal point puts the middle of both rectified images into
    the middle. Raises CalibrationError ``not_representable`` if the cameras are in one place, or no plane
    is in front of both.
    """
    length = float(np.linalg.norm(motion.t))
    if not length > 0:
        raise CalibrationError("not_representable", "cameras in one place have no epipolar lines")
    half = rotation.matrix(-0.5 * rotation.vector(motion.r))
    t = half @ motion.t
    axis = int(abs(t[1]) > abs(t[0]))
    along = np.zeros(3)
    along[axis] = 1.0 if t[axis] > 0 else -1.0
    turn_axis = np.cross(t, along)
    norm = float(np.linalg.norm(turn_axis))
    turn = np.eye(3)
    if norm > 0:
        angle = float(np.arccos(np.clip(abs(t[axis]) / length, -1, 1)))
        turn = rotation.matrix(turn_axis * (angle / norm))
    r1, r2 = turn @ half.T, turn @ half
    baseline = turn @ t
    focal = min(camera.focal[1 - axis] for camera in (one, other))
    centres = [_centre(camera, r) for camera, r in ((one, r1), (other, r2))]
    w, h = one.img_size
    middle = np.array([(w - 1) / 2, (h - 1) / 2]) - focal * np.mean(centres, axis=0)
    p1 = np.array([[focal, 0, middle[0], 0], [0, focal, middle[1], 0], [0, 0, 1, 0]])
    p2 = p1.copy()
    p2[axis, 3] = focal * baseline[axis]
    q = np.array(
        [
            [1, 0, 0, -middle[0]],
            [0, 1, 0, -middle[1]],
            [0, 0, 0, focal],
            [0, 0, -1 / baseline[axis], 0],
        ]
    )
    return Rectification(r1, r2, p1, p2, q, bool(axis))


def _centre(camera: Camera, r: Array) -> Array:
    """Mean (2,) of the rectified image's rim, for unit focal length."""
    w, h = camera.img_size
    x, y = np.meshgrid(np.linspace(0, w - 1, RIM_SAMPLES), np.linspace(0, h - 1, RIM_SAMPLES))
    rim = (x == 0) | (y == 0) | (x == w - 1) | (y == h - 1)
    pixels = np.stack([x, y], axis=-1)
    rays = camera.unproject(pixels[rim]) @ r.T
    visible = rays[np.isfinite(rays).all(axis=1) & (rays[:, 2] > 0.2)]
    middle = camera.unproject(np.array([[(w - 1) / 2, (h - 1) / 2]])) @ r.T
    if not middle[0, 2] > 0.2:
        raise CalibrationError("not_representable", "the cameras look in directions too far apart")
    if len(visible) < 0.75 * rim.sum():  # of a wide lens the middle says where its picture is
        visible = middle
    return np.asarray(np.mean(visible[:, :2] / visible[:, 2:], axis=0))
