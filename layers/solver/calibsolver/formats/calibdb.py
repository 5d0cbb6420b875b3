"""The service's own JSON, which loads in WPILib's WPIcal as it is."""

from .. import models
from ..arrays import Array
from ..camera import Camera
from ..errors import CalibrationError
from . import text
from .base import Conversion, Read, Shape, Subject
from .format import Format


class CalibDb(Format):
    """Top-level `camera`, nested 3x3 `camera_matrix`, flat `distortion_coefficients`."""

    name = "calibdb"
    suffix = ".json"
    media_type = "application/json"
    shapes = tuple(Shape(model) for model in models.NAMES)

    def write(self, subject: Subject, held: Conversion) -> bytes:
        """Write all that the service answers, with the camera that is held."""
        c = held.camera
        return text.dump(
            {
                **subject.record,
                "camera": subject.name,
                "img_size": list(c.img_size),
                "camera_matrix": c.matrix.tolist(),
                "distortion_coefficients": c.distortion.tolist(),
                "distortion_model": c.model,
                "avg_reprojection_error": subject.rms,
            },
            held.warning,
        )


def read(data: object) -> Read:
    """Read parsed JSON; CalibrationError ``malformed``."""
    model = text.member(data, "distortion_model") if has(data, "distortion_model") else "rectilinear"
    size = text.floats(text.member(data, "img_size"), "img_size", 2, 2)
    matrix = text.floats(text.member(data, "camera_matrix"), "camera_matrix", 9, 9).reshape(3, 3)
    d = text.floats(text.member(data, "distortion_coefficients"), "distortion_coefficients", 0, 14)
    found = data["camera"] if isinstance(data, dict) and isinstance(data.get("camera"), str) else ""
    return Read(camera(str(model), matrix, d, (int(size[0]), int(size[1]))), name=found)


def has(data: object, key: str) -> bool:
    """Tell whether parsed data is an object with such a member."""
    return isinstance(data, dict) and key in data


def camera(model: str, matrix: Array, d: Array, img_size: tuple[int, int]) -> Camera:
    """Return a camera read from a file; CalibrationError ``malformed`` where it is none."""
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


def opencv(matrix: Array, d: Array, img_size: tuple[int, int], fisheye: bool) -> Camera:
    """Return the camera of OpenCV's coefficients, however many are given (4, 5, 8; more if they are zero)."""
    d = d.copy()
    while len(d) > (4 if fisheye else 5) and d[-1] == 0 and len(d) != 8:
        d = d[:-1]
    if fisheye:
        return camera("fisheye", matrix, padded(d, 4), img_size)
    if len(d) <= 5:
        return camera("rectilinear", matrix, padded(d, 5), img_size)
    if len(d) == 8:
        return camera("rational", matrix, d, img_size)
    raise text.refuse(f"{len(d)} distortion coefficients (thin prism, tilt) are not supported")


def padded(d: Array, size: int) -> Array:
    """Append zeros."""
    if len(d) > size:
        raise text.refuse(f"{len(d)} distortion coefficients where at most {size} can be")
    full = d.copy()
    full.resize(size, refcheck=False)
    return full
