"""The service's own JSON, which loads in WPILib's WPIcal as it is where the model is OpenCV's."""

from dataclasses import replace

from . import text
from .base import ANY_MODEL, Conversion, ExportSource
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
