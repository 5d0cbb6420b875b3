"""Gyroflow's lens profile."""

import numpy as np

from . import text
from .base import Conversion, ExportSource, ImportedFile, ModelConstraint
from .coefficients import make_camera
from .format import Format


class Gyroflow(Format):
    """OpenCV's fisheye model; without `asymmetrical` the principal point would be taken to be the centre."""

    name = "gyroflow"
    suffix = ".json"
    media_type = "application/json"
    constraints = (ModelConstraint("fisheye"),)

    def write(self, source: ExportSource, conversion: Conversion) -> bytes:
        """Write the profile."""
        c = conversion.camera
        size = {"w": c.img_size[0], "h": c.img_size[1]}
        return text.dump(
            {
                "name": source.name,
                "note": conversion.warning or "",
                "calibrated_by": "calibDB",
                "camera_brand": source.name.split(" ")[0] if source.name else "",
                "camera_model": source.name,
                "lens_model": "",
                "camera_setting": "",
                "calib_dimension": size,
                "orig_dimension": size,
                "output_dimension": size,
                "input_horizontal_stretch": 1.0,
                "input_vertical_stretch": 1.0,
                "num_images": len(source.views),
                "use_opencv_fisheye": True,
                "fisheye_params": {
                    "RMS_error": source.rms,
                    "camera_matrix": np.asarray(c.matrix).tolist(),
                    "distortion_coeffs": c.distortion.tolist(),
                },
                "asymmetrical": True,
                "distortion_model": "opencv_fisheye",
                "identifier": source.identifier,
                "calibrator_version": "calibDB",
            },
            conversion.warning,
        )


def read(data: object) -> ImportedFile:
    """Read a parsed profile; CalibrationError ``malformed``."""
    size = (
        text.count(text.member(data, "calib_dimension", "w"), "calib_dimension.w"),
        text.count(text.member(data, "calib_dimension", "h"), "calib_dimension.h"),
    )
    data = data if isinstance(data, dict) else {}
    model = data.get("distortion_model", "opencv_fisheye")
    if model not in ("opencv_fisheye", "", None):
        raise text.refuse(f"distortion_model {model!r} is not supported, opencv_fisheye is")
    params = text.member(data, "fisheye_params")
    matrix = text.floats(text.member(params, "camera_matrix"), "camera_matrix", 9, 9).reshape(3, 3)
    d = text.floats(text.member(params, "distortion_coeffs"), "distortion_coeffs", 4, 4)
    if not data.get("asymmetrical"):
        matrix[:2, 2] = (size[0] / 2, size[1] / 2)  # the program would not use the one that is written
    brand, name = (str(data.get(key, "")) for key in ("camera_brand", "camera_model"))
    full = name if name.lower().startswith(brand.lower()) else f"{brand} {name}"
    return ImportedFile(make_camera("fisheye", matrix, d, size), name=full.strip())
