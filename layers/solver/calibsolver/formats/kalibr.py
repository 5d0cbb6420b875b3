"""Kalibr's camchain. Its reader wants exactly four coefficients, whole resolutions and floats elsewhere."""

import numpy as np

from ..errors import CalibrationError
from . import text
from .base import Conversion, ExportSource, ImportedFile, ModelConstraint
from .coefficients import make_camera, matrix_of, pad_coefficients
from .foreign_models import closest_camera, rays_of_kind
from .format import Format

INTRINSICS_COUNTS = {"pinhole": 4, "omni": 5}


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


def read(cam: object) -> ImportedFile:
    """Read one camera of a parsed camchain; CalibrationError ``malformed``."""
    w, h = text.floats(text.member(cam, "resolution"), "resolution", 2, 2)
    kind = str(text.member(cam, "camera_model")).lower()
    members = cam if isinstance(cam, dict) else {}
    model = str(members.get("distortion_model", "")).lower()
    values = text.floats(text.member(cam, "intrinsics"), "intrinsics", 4, 6)
    d = text.floats(members.get("distortion_coeffs", []), "distortion_coeffs", 0, 8)
    matrix = matrix_of(*values[-4:])
    size = text.width_height((w, h), ("resolution", "resolution"))
    if kind in ("ds", "eucm") and len(values) == 6 and not d.any():
        return closest_camera(rays_of_kind(kind, matrix, *values[:2].tolist()), size)
    if model in ("", "none") and not d.any():
        model, d = "radtan", np.zeros(4)
    if len(values) == INTRINSICS_COUNTS.get(kind) and len(d) == 4:
        if kind == "pinhole" and model in ("equidistant", "equi"):
            return ImportedFile(make_camera("fisheye", matrix, d, size))
        if kind == "pinhole" and model == "radtan":
            return ImportedFile(make_camera("rectilinear", matrix, pad_coefficients(d, 5), size))
        if kind == "omni" and model == "radtan":
            full = np.concatenate([values[:1], d])
            return ImportedFile(make_camera("omnidirectional", matrix, full, size))
    raise text.refuse(
        f"Kalibr's {kind} with {model} and {len(d)} coefficients is not supported; pinhole with radtan or "
        "equidistant, and omni with radtan, of four coefficients are"
    )
