"""ARToolKit's camera_para.dat, as AR.js loads it: version 4, OpenCV's model with four coefficients."""

import struct

import numpy as np

from .base import Conversion, ExportSource, ModelConstraint
from .format import Format


class ArToolKit(Format):
    """Big-endian: width, height (int32), the 3x4 matrix, then k1 k2 p1 p2 fx fy x0 y0 s (float64).

    The length of the file, 176 bytes, is what tells the version. s = 1: the ideal picture has the camera's
    own focal length.
    """

    name = "artoolkit"
    suffix = ".dat"
    media_type = "application/octet-stream"
    constraints = (ModelConstraint("rectilinear", zero=("k3",)),)

    def write(self, source: ExportSource, conversion: Conversion) -> bytes:  # noqa: ARG002 - every format has both
        """Write the file."""
        c = conversion.camera
        k = np.asarray(c.matrix)
        p = np.concatenate([k, np.zeros((3, 1))], axis=1)
        parameters = [*c.distortion[:4], k[0, 0], k[1, 1], k[0, 2], k[1, 2], 1.0]
        return struct.pack(">2i12d9d", *c.img_size, *p.ravel(), *parameters)
