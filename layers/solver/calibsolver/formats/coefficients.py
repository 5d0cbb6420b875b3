"""Cameras of distortion coefficients as in files: checked, padded, distinguished by their number."""

import numpy as np

from ..arrays import Array
from ..camera import Camera
from ..errors import CalibrationError
from . import text


def matrix_of(fx: float, fy: float, cx: float, cy: float) -> Array:
    """Return the camera matrix (3, 3) of focal lengths and centre, px."""
    return np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])


def make_camera(model: str, matrix: Array, d: Array, img_size: tuple[int, int]) -> Camera:
    """Make the camera that a file holds; CalibrationError ``malformed`` if there cannot be one."""
    w, h = img_size
    if not (1 <= w <= 65_536 and 1 <= h <= 65_536):
        raise text.refuse(f"a picture of {w} x {h} px is none")
    if not (matrix[0, 0] > 0 and matrix[1, 1] > 0):
        raise text.refuse("focal lengths must be positive")
    if abs(matrix[0, 1]) > 1e-9 * matrix[0, 0] or abs(matrix[2] - (0, 0, 1)).max() > 1e-9:
        raise text.refuse("the camera matrix must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]")
    try:
        return Camera(model, matrix, d, img_size)
    except CalibrationError as error:
        raise text.refuse(str(error)) from None


def camera_from_opencv(matrix: Array, d: Array, img_size: tuple[int, int], fisheye: bool) -> Camera:
    """Make the camera of OpenCV's coefficients, however many are given (4, 5, 8; more if they are zero)."""
    d = d.copy()
    while len(d) > (4 if fisheye else 5) and d[-1] == 0 and len(d) != 8:
        d = d[:-1]
    if fisheye:
        return make_camera("fisheye", matrix, pad_coefficients(d, 4), img_size)
    if len(d) <= 5:
        return make_camera("rectilinear", matrix, pad_coefficients(d, 5), img_size)
    if len(d) == 8:
        return make_camera("rational", matrix, d, img_size)
    raise text.refuse(f"{len(d)} distortion coefficients (thin prism, tilt) are not supported")


def pad_coefficients(d: Array, size: int) -> Array:
    """Append zeros."""
    if len(d) > size:
        raise text.refuse(f"{len(d)} distortion coefficients where at most {size} can be")
    full = d.copy()
    full.resize(size, refcheck=False)
    return full
