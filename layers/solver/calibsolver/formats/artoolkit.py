"""ARToolKit's camera_para.dat, as AR.js loads it: version 4, OpenCV's model with four coefficients."""

import struct

import numpy as np

from . import text
from .base import Conversion, ExportSource, ImportedFile, ModelConstraint
from .coefficients import camera_from_opencv, matrix_of
from .format import Format


class ArToolKit(Format):
    """Big-endian: width, height (int32), the 3x4 matrix, then k1 k2 p1 p2 fx fy x0 y0 s (float64).

    The length of the file, 176 bytes, determines the version. s = 1: the ideal picture has the camera's
    own focal length.
    """

    name = "artoolkit"
    suffix = ".dat"
    constraints = (ModelConstraint("rectilinear", zero=("k3",)),)

    def write(self, source: ExportSource, conversion: Conversion) -> bytes:
        c = conversion.camera
        p = np.column_stack([c.matrix, np.zeros(3)])
        return struct.pack(">2i12d9d", *c.img_size, *p.ravel(), *c.distortion[:4], *c.intrinsics[:4], 1.0)


_HEAD = struct.Struct(">2i12d")
FACTORS = {_HEAD.size + 8 * count: count for count in (4, 5, 6, 9, 17)}
"""Numbers of distortion factors by the length of a file, versions 1 to 5."""


def is_parameters(raw: bytes) -> bool:
    """True if bytes are a camera_para.dat: by their length, and the size of a picture in front."""
    if len(raw) not in FACTORS:
        return False
    w, h = (int(side) for side in struct.unpack_from(">2i", raw))
    return 16 <= w <= 65_536 and 16 <= h <= 65_536


def read(raw: bytes) -> ImportedFile:
    """Read a camera_para.dat of version 4 or 5; CalibrationError ``malformed``.

    Source: ARToolKit 5, `lib/SRC/AR/param.c`: the factors of version 4 are k1 k2 p1 p2 fx fy x0 y0 s, those
    of version 5 k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 fx fy x0 y0 s.
    """
    count = FACTORS[len(raw)]
    w, h, *_ = _HEAD.unpack_from(raw)
    factors = text.floats(list(struct.unpack_from(f">{count}d", raw, _HEAD.size)), "factors", count, count)
    if count not in (9, 17):
        raise text.refuse(
            "a camera_para.dat of versions 1 to 3, whose distortion is not OpenCV's: calibrate again with a "
            "newer ARToolKit"
        )
    matrix = matrix_of(*factors[-5:-1])
    return ImportedFile(camera_from_opencv(matrix, factors[:-5], (w, h), fisheye=False))
