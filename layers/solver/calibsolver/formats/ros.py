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
    media_type = "application/yaml"
    constraints = (ModelConstraint("rectilinear"), ModelConstraint("rational"), ModelConstraint("fisheye"))

    def write(self, source: ExportSource, conversion: Conversion) -> bytes:
        """Write the members in the order that ROS writes them."""
        k = np.asarray(conversion.camera.matrix)
        return self.write_rectified(source, conversion, np.eye(3), np.column_stack([k, np.zeros(3)]))

    def write_rectified(self, source: ExportSource, conversion: Conversion, r: Array, p: Array) -> bytes:
        """Write the camera with the rotation (3, 3) that rectifies it and the projection (3, 4) after it."""
        c = conversion.camera
        k = np.asarray(c.matrix)
        name = "".join(ch if ch.isascii() and ch.isalnum() else "_" for ch in source.name) or "camera"
        return text.lines(
            self.comment(source, conversion),
            f"image_width: {c.img_size[0]}",
            f"image_height: {c.img_size[1]}",
            f"camera_name: {text.quote(name)}",
            self._matrix("camera_matrix", 3, 3, k.ravel()),
            f"distortion_model: {ROS_MODELS[c.model]}",
            self._matrix("distortion_coefficients", 1, len(c.distortion), c.distortion),
            self._matrix("rectification_matrix", 3, 3, r.ravel()),
            self._matrix("projection_matrix", 3, 4, p.ravel()),
        )

    @staticmethod
    def _matrix(name: str, rows: int, columns: int, data: Array) -> list[str]:
        return [f"{name}:", f"  rows: {rows}", f"  cols: {columns}", f"  data: [{text.numbers(data)}]"]
