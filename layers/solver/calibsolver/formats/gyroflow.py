"""Gyroflow's lens profile."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from . import text
from .base import Conversion, ExportSource, ImportedFile, ModelConstraint
from .coefficients import camera_from_opencv, make_camera, pad_coefficients
from .format import Format

MIN_STRETCH, MAX_STRETCH = 0.01, 4.0
"""Anamorphic factors: up to the first there is none, beyond the second no lens has it."""


class Gyroflow(Format):
    """OpenCV's fisheye model; without `asymmetrical` the principal point would be taken to be the centre."""

    name = "gyroflow"
    front_readers = "Gyroflow"
    suffix = ".json"
    constraints = (ModelConstraint("fisheye"),)

    def write(self, source: ExportSource, conversion: Conversion) -> bytes:
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
                    "camera_matrix": c.matrix.tolist(),
                    "distortion_coeffs": c.distortion.tolist(),
                },
                "asymmetrical": True,
                "distortion_model": "opencv_fisheye",
                "identifier": source.identifier,
                "calibrator_version": "calibDB",
            },
            conversion.warning,
        )


def read(data: Mapping[str, Any]) -> ImportedFile:
    """Read a parsed profile; CalibrationError ``malformed``.

    The profile of an anamorphic lens is of the picture stretched to its proper width and height; the camera's
    own picture is that one, compressed again. A digital lens (GoPro's SuperView and the like) bends the
    picture once more, as no camera model does.
    """
    names = ("calib_dimension.w", "calib_dimension.h")
    stretched = text.width_height((text.member(data, *name.split(".")) for name in names), names)
    digital = data.get("digital_lens") or ("gopro_superview" if data.get("is_superview") is True else "")
    if digital:
        raise text.refuse(
            f"the camera's picture is bent by a digital lens ({str(digital)[:40]}), which no camera model "
            "holds: use a profile of a mode without it"
        )
    params = text.member(data, "fisheye_params")
    matrix = text.floats(text.member(params, "camera_matrix"), "camera_matrix", 9, 9).reshape(3, 3)
    d = text.floats(text.member(params, "distortion_coeffs"), "distortion_coeffs", 0, 12)
    if not data.get("asymmetrical"):
        matrix[:2, 2] = np.array(stretched) / 2  # the program would not use the one that is written
    stretch = np.array([_stretch(data, "input_horizontal_stretch"), _stretch(data, "input_vertical_stretch")])
    size = (max(1, round(stretched[0] / stretch[0])), max(1, round(stretched[1] / stretch[1])))
    matrix[:2] /= stretch[:, None]
    brand, name = (str(data.get(key) or "") for key in ("camera_brand", "camera_model"))
    full = (name if name.lower().startswith(brand.lower()) else f"{brand} {name}").strip()
    model = data.get("distortion_model") or "opencv_fisheye"
    if model == "opencv_fisheye":
        return ImportedFile(make_camera("fisheye", matrix, pad_coefficients(d, 4), size), name=full)
    if model == "opencv_standard":
        return ImportedFile(camera_from_opencv(matrix, d, size, fisheye=False), name=full)
    raise text.refuse(
        f"distortion_model {str(model)[:40]!r} is not supported, opencv_fisheye and opencv_standard are"
    )


def _stretch(data: Mapping[str, Any], key: str) -> float:
    """Factor by which the camera's picture is stretched; like Gyroflow, a missing one and nearly 0 are 1."""
    value = data.get(key)
    stretch = text.scalar(value, key) if value is not None else 1.0
    if stretch <= MIN_STRETCH:
        return 1.0
    if not 1 / MAX_STRETCH <= stretch <= MAX_STRETCH:
        raise text.refuse(f"{key} {stretch:g} is that of no lens")
    return stretch
