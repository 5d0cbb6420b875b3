"""DNG's lens corrections: an OpcodeList3 with WarpRectilinear or WarpFisheye.

An opcode maps the corrected picture to the one that was taken: radii are divided by m, the distance of the
optical centre from the farthest corner. (Digital Negative Specification 1.4 and later, chapter 7.)
"""

import math
import struct

import numpy as np

from ..camera import Camera
from .base import Conversion, ExportSource, ModelConstraint
from .convert import compare, convert_in_image, differences
from .format import Format

WARP_RECTILINEAR, WARP_FISHEYE = 1, 2
VERSION = 0x01030000
"""Of the specification that introduced both."""
OPTIONAL = 1
"""Flag: a reader that does not know the opcode may leave it out."""
MAX_ANGLE_RAD = math.pi / 4
"""Angle from the axis that WarpFisheye reaches: in the corrected picture the radius is m tan(angle) <= m."""


class Dng(Format):
    """The opcode list as bytes, to be put into the tag OpcodeList3 (for all planes alike).

    WarpRectilinear keeps the focal length, kr = [1, k1 g^2, k2 g^4, k3 g^6], kt = [p1 g, p2 g], g = m / f.
    WarpFisheye corrects to a pinhole of focal length m, kr = f/m [1, k1, k2, k3]: four terms stand for five.
    Neither has room for fx other than fy.
    """

    name = "dng"
    suffix = ".opcodelist3"
    constraints = (
        ModelConstraint("rectilinear", equal_focal=True),
        ModelConstraint("fisheye", equal_focal=True),
    )

    def convert(self, source: ExportSource) -> Conversion:
        conversion = convert_in_image(source, self.constraints)
        if conversion.camera.model != "fisheye":
            return conversion
        four = _refit_without_k4(conversion.camera)
        error, _ = differences(source.camera, four.project, MAX_ANGLE_RAD)
        return Conversion(four, error, compare(source.camera, four).coverage)

    def write(self, source: ExportSource, conversion: Conversion) -> bytes:
        c = conversion.camera
        (w, h), k = c.img_size, c.matrix
        f, m = float(k[0, 0]), farthest(c)
        g, d = m / f, c.distortion
        if c.model == "fisheye":
            code, values = WARP_FISHEYE, [(f / m) * term for term in (1.0, *d[:3])]
        else:
            code = WARP_RECTILINEAR
            values = [1.0, d[0] * g**2, d[1] * g**4, d[4] * g**6, d[2] * g, d[3] * g]
        body = struct.pack(f">I{len(values)}d2d", 1, *values, k[0, 2] / w, k[1, 2] / h)
        return struct.pack(">5I", 1, code, VERSION, OPTIONAL, len(body)) + body


def farthest(camera: Camera) -> float:
    """m, px: the distance of the principal point from the farthest corner of the picture."""
    (w, h), (cx, cy) = camera.img_size, camera.matrix[:2, 2]
    return math.hypot(max(cx, w - cx), max(cy, h - cy))


def _refit_without_k4(camera: Camera) -> Camera:
    """Return the fisheye camera with k4 = 0 that is closest over the angles that the opcode reaches."""
    if camera.distortion[3] == 0:
        return camera
    t = np.linspace(0, MAX_ANGLE_RAD, 200)[1:]
    powers = np.stack([t, t**3, t**5, t**7], axis=1)
    radius = t * (1 + t**2 * np.polynomial.polynomial.polyval(t**2, camera.distortion))
    terms = np.linalg.lstsq(powers, radius, rcond=None)[0]
    matrix = np.array(camera.matrix)
    matrix[0, 0] *= terms[0]
    matrix[1, 1] *= terms[0]
    return Camera("fisheye", matrix, np.append(terms[1:] / terms[0], 0.0), camera.img_size)
