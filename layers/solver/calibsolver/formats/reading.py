"""Other tools' files read: what kind one is, and what it says."""

from collections.abc import Mapping

from . import gyroflow, kalibr, mrcal, native, opencv, photonvision, ros, text
from .base import ImportedFile


def read(data: object) -> ImportedFile:
    """Read a parsed JSON or YAML file, whichever of the known kinds it is.

    Raises CalibrationError ``malformed``, which says what is missing or wrong.
    """
    if not isinstance(data, Mapping):
        raise text.refuse("the file is no object with members")
    if "cam0" in data:
        return kalibr.read(data)
    if "fisheye_params" in data:
        return gyroflow.read(data)
    if "cameraIntrinsics" in data:
        return photonvision.read(data)
    if data.get("distortion_model") in ros.ROS_MODELS.values():
        return ros.read(data)
    if "img_size" in data:
        return native.read(data)
    if "camera_matrix" in data:
        return opencv.read(data)
    raise text.refuse("the file is of no kind that is known here")


def read_text(content: str, squares: tuple[int, int] | None = None) -> ImportedFile:
    """Read a .cameramodel, or a table of corners of a board of so many squares.

    Raises CalibrationError ``malformed``.
    """
    if "lensmodel" in content:
        return mrcal.read(content)
    if squares is None:
        raise text.refuse("a table of corners does not say what board it is of: give its squares")
    return mrcal.read_corners(content, squares)
