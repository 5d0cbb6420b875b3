"""COLMAP's cameras.txt. Its image origin is the *corner* of the top-left pixel: half a pixel more."""

import numpy as np

from . import text
from .base import Conversion, ExportSource, ModelConstraint
from .format import Format

HALF = 0.5


class Colmap(Format):
    """One line: OPENCV where k3 is zero, FULL_OPENCV otherwise, OPENCV_FISHEYE."""

    name = "colmap"
    suffix = ".txt"
    constraints = (ModelConstraint("rectilinear"), ModelConstraint("rational"), ModelConstraint("fisheye"))

    def write(self, source: ExportSource, conversion: Conversion) -> bytes:
        """Write the file; `source`'s name is a comment."""
        c = conversion.camera
        k, d = np.asarray(c.matrix), np.asarray(c.distortion)
        model = "OPENCV_FISHEYE" if c.model == "fisheye" else "FULL_OPENCV"
        if c.model == "rectilinear":
            if d[4] == 0:
                model, d = "OPENCV", d[:4]
            else:
                d = np.append(d, np.zeros(3))
        params = [k[0, 0], k[1, 1], k[0, 2] + HALF, k[1, 2] + HALF, *d]
        return text.lines(
            "# Camera list with one line of data per camera:",
            "#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]",
            self.comment(source, conversion),
            f"1 {model} {c.img_size[0]} {c.img_size[1]} {' '.join(text.number(p) for p in params)}",
        )
