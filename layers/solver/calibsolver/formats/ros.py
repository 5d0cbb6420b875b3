"""ROS camera_info, as camera_info_manager and camera_calibration_parsers read it."""

import numpy as np

from ..arrays import Array
from . import text
from .base import Conversion, ExportSource, ModelConstraint
from .format import Format

ROS_MODELS = {"rectilinear": "plumb_bob", "rational": "rational_polynomial", "fisheye": "equidistant"}


class Ros(Format):
    """camera_info YAML in full precision; rectified by the identity, projected by K."""

    name = "ros"
    front_readers = "ROS (image_geometry)"
    suffix = ".yaml"
    constraints = (ModelConstraint("rectilinear"), ModelConstraint("rational"), ModelConstraint("fisheye"))

    def write(self, source: ExportSource, conversion: Conversion) -> bytes:
        p = np.column_stack([conversion.camera.matrix, np.zeros(3)])
        return self.write_rectified(source, conversion, np.eye(3), p)

    def write_rectified(self, source: ExportSource, conversion: Conversion, r: Array, p: Array) -> bytes:
        """Write the camera with the rotation (3, 3) that rectifies it and the projection (3, 4) after it."""
        c = conversion.camera
        name = "".join(ch if ch.isascii() and ch.isalnum() else "_" for ch in source.name) or "camera"
        return text.lines(
            self.comment(source, conversion),
            f"image_width: {c.img_size[0]}",
            f"image_height: {c.img_size[1]}",
            f"camera_name: {text.quote(name)}",
            self._matrix("camera_matrix", c.matrix),
            f"distortion_model: {ROS_MODELS[c.model]}",
            self._matrix("distortion_coefficients", c.distortion[None]),
            self._matrix("rectification_matrix", r),
            self._matrix("projection_matrix", p),
        )

    @staticmethod
    def _matrix(name: str, m: Array) -> list[str]:
        rows, columns = m.shape
        return [f"{name}:", f"  rows: {rows}", f"  cols: {columns}", f"  data: [{text.numbers(m.ravel())}]"]
