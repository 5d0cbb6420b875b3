"""OpenSfM's camera_models.json. Lengths are in units of the larger side, the origin is the image's centre."""

import numpy as np

from ..camera import Camera
from . import text
from .base import Conversion, ExportSource, ImportedFile, ModelConstraint
from .coefficients import camera_from_opencv, matrix_of
from .format import Format


class OpenSfm(Format):
    """`brown` and `fisheye_opencv` cameras."""

    name = "opensfm"
    front_readers = "OpenSfM"
    suffix = ".json"
    media_type = "application/json"
    constraints = (ModelConstraint("rectilinear"), ModelConstraint("fisheye"))

    def write(self, source: ExportSource, conversion: Conversion) -> bytes:
        """Write one camera under the source's name."""
        value = members(conversion.camera)
        if conversion.warning:
            value["warning"] = conversion.warning
        return text.dump({source.name or "camera": value})


def members(camera: Camera) -> dict[str, object]:
    """Return the members of a rectilinear camera or a fisheye."""
    (w, h), k = camera.img_size, camera.matrix
    side = max(w, h)
    names = ("k1", "k2", "p1", "p2", "k3") if camera.model == "rectilinear" else ("k1", "k2", "k3", "k4")
    return {
        "projection_type": "brown" if camera.model == "rectilinear" else "fisheye_opencv",
        "width": w,
        "height": h,
        "focal_x": k[0, 0] / side,
        "focal_y": k[1, 1] / side,
        "c_x": (k[0, 2] - (w - 1) / 2) / side,
        "c_y": (k[1, 2] - (h - 1) / 2) / side,
        **dict(zip(names, camera.distortion.tolist(), strict=True)),
    }


def read(data: object) -> ImportedFile:
    """Read one parsed camera; CalibrationError ``malformed``."""
    kind = text.member(data, "projection_type")
    size = (
        text.count(text.member(data, "width"), "width"),
        text.count(text.member(data, "height"), "height"),
    )
    if kind not in ("brown", "perspective", "simple_radial", "radial", "fisheye", "fisheye_opencv"):
        raise text.refuse(f"OpenSfM's projection_type {str(kind)[:40]!r} is not supported")
    values = dict(data) if isinstance(data, dict) else {}

    def value(*names: str) -> float:
        number = next((values[name] for name in names if name in values), 0.0)
        return float(text.floats(number, names[0], 1, 1)[0])

    side, fisheye = max(size), kind in ("fisheye", "fisheye_opencv")
    fx, fy = value("focal_x", "focal") * side, value("focal_y", "focal", "focal_x") * side
    cx, cy = value("c_x") * side + (size[0] - 1) / 2, value("c_y") * side + (size[1] - 1) / 2
    names = ("k1", "k2", "k3", "k4") if fisheye else ("k1", "k2", "p1", "p2", "k3")
    d = np.array([value(name) for name in names])
    return ImportedFile(camera_from_opencv(matrix_of(fx, fy, cx, cy), d, size, fisheye))
