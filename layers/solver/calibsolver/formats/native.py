"""The service's own JSON, which loads in WPILib's WPIcal as it is where the model is OpenCV's."""

from collections.abc import Mapping
from dataclasses import replace

from . import text
from .base import ANY_MODEL, Conversion, ExportSource, ImportedFile
from .coefficients import make_camera
from .format import Format


class NativeJson(Format):
    """Top-level `camera`, nested 3x3 `camera_matrix`, flat `distortion_coefficients`."""

    name = "calibdb"
    suffix = ".json"
    constraints = ANY_MODEL

    def check(self, conversion: Conversion) -> Conversion:
        if conversion.camera.model in ("rectilinear", "rational"):
            return conversion
        return replace(
            conversion,
            remark=f"Not for WPIcal, which takes the {conversion.camera.model} coefficients for "
            "OpenCV's rectilinear ones.",
        )

    def write(self, source: ExportSource, conversion: Conversion) -> bytes:
        return text.dump(
            {
                **source.record,
                "camera": source.name,
                **conversion.camera.record(),
                "avg_reprojection_error": source.rms,
            },
            conversion.warning,
        )


def read(data: object) -> ImportedFile:
    """Read parsed JSON; CalibrationError ``malformed``."""
    given = data if isinstance(data, Mapping) else {}
    model, label = given.get("distortion_model", "rectilinear"), given.get("camera")
    size = text.floats(text.member(data, "img_size"), "img_size", 2, 2)
    matrix = text.floats(text.member(data, "camera_matrix"), "camera_matrix", 9, 9).reshape(3, 3)
    d = text.floats(text.member(data, "distortion_coefficients"), "distortion_coefficients", 0, 14)
    camera = make_camera(str(model), matrix, d, (int(size[0]), int(size[1])))
    return ImportedFile(camera, name=label if isinstance(label, str) else "")
