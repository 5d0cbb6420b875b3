"""Kalibr's camchain. Its reader wants exactly four coefficients, whole resolutions and floats elsewhere."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..errors import CalibrationError
from . import generic, text
from .base import Conversion, ExportSource, ImportedFile, ModelConstraint, ReaderOptions
from .format import Format

FOREIGN = {"ds": ("xi", "alpha"), "eucm": ("alpha", "beta")}


class Kalibr(Format):
    """One camera, `cam0`: pinhole-radtan, pinhole-equidistant or omni-radtan."""

    name = "kalibr"
    front_readers = "Kalibr"
    suffix = ".yaml"
    constraints = (
        ModelConstraint("rectilinear", zero=("k3",)),
        ModelConstraint("fisheye"),
        ModelConstraint("omnidirectional"),
    )

    def check(self, conversion: Conversion) -> Conversion:
        cx, cy = conversion.camera.matrix[:2, 2]
        if cx < 0 or cy < 0:
            raise CalibrationError(
                "not_representable",
                f"Kalibr refuses a principal point left of or above the image, here {cx:.1f}, {cy:.1f}: "
                "crop less, or take another format",
            )
        return super().check(conversion)

    def write(self, source: ExportSource, conversion: Conversion) -> bytes:
        c = conversion.camera
        intrinsics, d = c.intrinsics[:4], c.distortion
        model = "equidistant" if c.model == "fisheye" else "radtan"
        if c.model == "omnidirectional":
            intrinsics, d = np.append(d[0], intrinsics), d[1:]
        return text.lines(
            self.comment(source, conversion),
            "cam0:",
            f"  camera_model: {'omni' if c.model == 'omnidirectional' else 'pinhole'}",
            f"  intrinsics: [{text.numbers(intrinsics)}]",
            f"  distortion_model: {model}",
            f"  distortion_coeffs: [{text.numbers(d[:4])}]",
            f"  resolution: [{c.img_size[0]}, {c.img_size[1]}]",
            "  rostopic: /cam0/image_raw",
        )


def is_foreign(cam: Mapping[Any, Any]) -> bool:
    """True if a camera of a camchain is of a model that calibsolver lacks, its parameters before fx."""
    return {"camera_model", "intrinsics", "resolution"} <= cam.keys() and _kind(cam) in FOREIGN


def read_foreign(cam: Mapping[Any, Any]) -> ImportedFile:
    """Read such a camera: the closest one; CalibrationError ``malformed``."""
    kind = _kind(cam)
    if text.floats(cam.get("distortion_coeffs", []), "distortion_coeffs", 0, 8).any():
        raise text.refuse(f"Kalibr's {kind} with distortion_coeffs is not supported")
    values = text.floats(cam["intrinsics"], "intrinsics", 6, 6).tolist()
    named = dict(zip((*FOREIGN[kind], "fx", "fy", "cx", "cy"), values, strict=True))
    return generic.read({**named, "type": kind, "resolution": cam["resolution"]}, ReaderOptions())


def _kind(cam: Mapping[Any, Any]) -> str:
    return str(cam["camera_model"]).lower()
