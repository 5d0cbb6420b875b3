"""OpenSfM's camera_models.json. Lengths are in units of the larger side, the origin is the image's centre."""

import numpy as np

from ..camera import Camera
from . import text
from .base import Conversion, ExportSource, ImportedFile, ModelConstraint
from .coefficients import camera_from_opencv, matrix_of
from .format import Format


class OpenSfm(Format):
    """One `brown` or `fisheye_opencv` camera under the source's name."""

    name = "opensfm"
    front_readers = "OpenSfM"
    suffix = ".json"
    constraints = (ModelConstraint("rectilinear"), ModelConstraint("fisheye"))

    def write(self, source: ExportSource, conversion: Conversion) -> bytes:
        value = members(conversion.camera)
        if conversion.warning:
            value["warning"] = conversion.warning
        return text.dump({source.name or "camera": value})


def members(camera: Camera) -> dict[str, object]:
    """Return the members of a rectilinear camera or a fisheye."""
    (w, h), (fx, fy, cx, cy) = camera.img_size, camera.intrinsics[:4]
    side = max(w, h)
    names = ("k1", "k2", "p1", "p2", "k3") if camera.model == "rectilinear" else ("k1", "k2", "k3", "k4")
    return {
        "projection_type": "brown" if camera.model == "rectilinear" else "fisheye_opencv",
        "width": w,
        "height": h,
        "focal_x": fx / side,
        "focal_y": fy / side,
        "c_x": (cx - (w - 1) / 2) / side,
        "c_y": (cy - (h - 1) / 2) / side,
        **dict(zip(names, camera.distortion.tolist(), strict=True)),
    }


def read(data: object) -> ImportedFile:
    """Read one parsed camera; CalibrationError ``malformed``."""
    kind = text.member(data, "projection_type")
    size = text.width_height((text.member(data, "width"), text.member(data, "height")))
    if kind not in ("brown", "perspective", "simple_radial", "radial", "fisheye", "fisheye_opencv"):
        raise text.refuse(f"OpenSfM's projection_type {str(kind)[:40]!r} is not supported")
    values = dict(data) if isinstance(data, dict) else {}

    def value(*names: str) -> float:
        number = next((values[name] for name in names if name in values), 0.0)
        return text.scalar(number, names[0])

    side, fisheye = max(size), kind in ("fisheye", "fisheye_opencv")
    fx, fy = value("focal_x", "focal") * side, value("focal_y", "focal", "focal_x") * side
    cx, cy = value("c_x") * side + (size[0] - 1) / 2, value("c_y") * side + (size[1] - 1) / 2
    names = ("k1", "k2", "k3", "k4") if fisheye else ("k1", "k2", "p1", "p2", "k3")
    d = np.array([value(name) for name in names])
    return ImportedFile(camera_from_opencv(matrix_of(fx, fy, cx, cy), d, size, fisheye))
