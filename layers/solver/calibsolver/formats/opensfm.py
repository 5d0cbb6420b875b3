"""OpenSfM's camera_models.json. Lengths are in units of the larger side, the origin is the image's centre."""

import numpy as np

from . import text
from .base import Conversion, ExportSource, ModelConstraint
from .format import Format


class OpenSfm(Format):
    """`brown` and `fisheye_opencv` cameras."""

    name = "opensfm"
    suffix = ".json"
    media_type = "application/json"
    constraints = (ModelConstraint("rectilinear"), ModelConstraint("fisheye"))

    def write(self, source: ExportSource, conversion: Conversion) -> bytes:
        """Write one camera under the source's name."""
        c = conversion.camera
        (w, h), k = c.img_size, np.asarray(c.matrix)
        side = max(w, h)
        names = ("k1", "k2", "p1", "p2", "k3") if c.model == "rectilinear" else ("k1", "k2", "k3", "k4")
        value = {
            "projection_type": "brown" if c.model == "rectilinear" else "fisheye_opencv",
            "width": w,
            "height": h,
            "focal_x": k[0, 0] / side,
            "focal_y": k[1, 1] / side,
            "c_x": (k[0, 2] - (w - 1) / 2) / side,
            "c_y": (k[1, 2] - (h - 1) / 2) / side,
            **dict(zip(names, c.distortion.tolist(), strict=True)),
        }
        if conversion.warning:
            value["warning"] = conversion.warning
        return text.dump({source.name or "camera": value})
