"""Formats for pages: the WebXR attributes, and glTF's camera."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..arrays import Array
from ..camera import Camera
from . import text
from .base import ANY_MODEL, Conversion, ExportSource
from .convert import compare
from .format import Format

NEAR, FAR = 0.1, 1000.0


def projection_matrix(camera: Camera) -> Array:
    """Return OpenGL's projection (4, 4) of the camera without its distortion, the viewport its whole image.

    Column vectors; clip space as in WebXR: x right, y up, the view frame diag(1, -1, -1) times ours.
    """
    (w, h), k = camera.img_size, camera.matrix
    p = np.zeros((4, 4))
    p[0, 0], p[1, 1] = 2 * k[0, 0] / w, 2 * k[1, 1] / h
    # pixel centres are at whole numbers, the edge of the viewport is half a pixel further out
    p[0, 2], p[1, 2] = 1 - 2 * (k[0, 2] + 0.5) / w, 2 * (k[1, 2] + 0.5) / h - 1
    p[2, 2], p[2, 3], p[3, 2] = -(FAR + NEAR) / (FAR - NEAR), -2 * FAR * NEAR / (FAR - NEAR), -1
    return p


class WebXr(Format):
    """The attributes of the lens extension of XRView, matrices column-major as in WebXR."""

    name = "webxr"
    suffix = ".json"
    constraints = ANY_MODEL

    def write(self, source: ExportSource, conversion: Conversion) -> bytes:
        c = conversion.camera
        return text.dump(
            {
                "camera": source.name,
                "viewport": {"x": 0, "y": 0, "width": c.img_size[0], "height": c.img_size[1]},
                "cameraMatrix": c.matrix.ravel(order="F").tolist(),
                "distortionModel": c.model,
                "distortionCoefficients": c.distortion.tolist(),
                "depthNear": NEAR,
                "depthFar": FAR,
                "projectionMatrix": projection_matrix(c).ravel(order="F").tolist(),
            },
            conversion.warning,
        )


class Gltf(Format):
    """A glTF 2.0 scene with one perspective camera; what its two numbers leave out is in `extras`."""

    name = "gltf"
    suffix = ".gltf"
    constraints = ANY_MODEL

    def convert(self, source: ExportSource) -> Conversion:
        c = source.camera
        (w, h), matrix = c.img_size, np.array(c.matrix)
        matrix[:2, 2] = (w - 1) / 2, (h - 1) / 2
        return compare(c, Camera("rectilinear", matrix, np.zeros(5), c.img_size))

    def write(self, source: ExportSource, conversion: Conversion) -> bytes:
        c = source.camera
        (w, h), k = c.img_size, c.matrix
        camera = {
            "name": source.name,
            "type": "perspective",
            "perspective": {
                "yfov": 2 * math.atan(h / (2 * float(k[1, 1]))),
                "aspectRatio": w * float(k[1, 1]) / (h * float(k[0, 0])),
                "znear": NEAR,
                "zfar": FAR,
            },
            "extras": {**c.record(), "warning": conversion.warning},
        }
        return text.dump(scene([{"name": source.name, "camera": 0}], [camera]))


def scene(
    nodes: Sequence[Mapping[str, Any]], cameras: Sequence[Mapping[str, Any]], **asset: Any
) -> dict[str, Any]:
    """Return a glTF document whose scene has these nodes."""
    return {
        "asset": {"version": "2.0", "generator": "calibDB", **asset},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "cameras": cameras,
    }
