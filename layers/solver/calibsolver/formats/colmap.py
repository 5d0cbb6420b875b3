"""COLMAP's cameras.txt. Its image origin is the *corner* of the top-left pixel: half a pixel more."""

import re

import numpy as np

from ..camera import Camera
from . import text
from .base import Conversion, ExportSource, ImportedFile, ModelConstraint
from .coefficients import camera_from_opencv, matrix_of
from .format import Format

HALF = 0.5
MODELS = {
    "SIMPLE_PINHOLE": ("f cx cy", False),
    "PINHOLE": ("fx fy cx cy", False),
    "SIMPLE_RADIAL": ("f cx cy k1", False),
    "RADIAL": ("f cx cy k1 k2", False),
    "OPENCV": ("fx fy cx cy k1 k2 p1 p2", False),
    "FULL_OPENCV": ("fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6", False),
    "SIMPLE_RADIAL_FISHEYE": ("f cx cy k1", True),
    "RADIAL_FISHEYE": ("f cx cy k1 k2", True),
    "OPENCV_FISHEYE": ("fx fy cx cy k1 k2 k3 k4", True),
}
"""Parameters of the models that are known here, and whether they are of the angle."""
MAX_LINE_LENGTH = 1000
_LINE = re.compile(r"\d{1,9} ([A-Z][A-Z_]{2,40}) (\d{1,9}) (\d{1,9})((?: [-+.eE\d]+)+)", re.ASCII)


class Colmap(Format):
    """One line: OPENCV where k3 is zero, FULL_OPENCV otherwise, OPENCV_FISHEYE."""

    name = "colmap"
    front_readers = "COLMAP"
    suffix = ".txt"
    constraints = (ModelConstraint("rectilinear"), ModelConstraint("rational"), ModelConstraint("fisheye"))

    def write(self, source: ExportSource, conversion: Conversion) -> bytes:
        (w, h), (model, params) = conversion.camera.img_size, parameters(conversion.camera)
        return text.lines(
            "# Camera list with one line of data per camera:",
            "#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]",
            self.comment(source, conversion),
            f"1 {model} {w} {h} {' '.join(text.number(p) for p in params)}",
        )


def parameters(camera: Camera) -> tuple[str, list[float]]:
    """Return the name of COLMAP's model of a camera that is not omnidirectional, and its parameters."""
    d = camera.distortion
    model = "OPENCV_FISHEYE" if camera.model == "fisheye" else "FULL_OPENCV"
    if camera.model == "rectilinear":
        if d[4] == 0:
            model, d = "OPENCV", d[:4]
        else:
            d = np.append(d, np.zeros(3))
    fx, fy, cx, cy = camera.intrinsics[:4]
    return model, [fx, fy, cx + HALF, cy + HALF, *d]


def lines_of_cameras(content: str) -> list[dict[str, object]]:
    """Return the cameras of a cameras.txt, for `read`; none if it is another file."""
    lines = (" ".join(line.split()) for line in content.splitlines() if len(line) <= MAX_LINE_LENGTH)
    return [
        {"colmap_model": match[1], "size": [int(match[2]), int(match[3])], "params": match[4].split()}
        for match in map(_LINE.fullmatch, lines)
        if match
    ]


def read(data: object) -> ImportedFile:
    """Read one camera of `lines_of_cameras`; CalibrationError ``malformed``."""
    model = str(text.member(data, "colmap_model"))
    if model not in MODELS:
        raise text.refuse(f"COLMAP's {model} is not supported; {', '.join(MODELS)} are")
    names, fisheye = MODELS[model]
    count = len(names.split())
    values = dict(
        zip(names.split(), text.floats(text.member(data, "params"), "PARAMS", count, count), strict=True)
    )
    w, h = (text.count(side, "WIDTH, HEIGHT") for side in text.member(data, "size"))
    fx, fy = (values[name if name in values else "f"] for name in ("fx", "fy"))
    matrix = matrix_of(fx, fy, values["cx"] - HALF, values["cy"] - HALF)
    order = ("k1", "k2", "k3", "k4") if fisheye else ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")
    d = np.array([values.get(name, 0.0) for name in order])
    return ImportedFile(camera_from_opencv(matrix, d, (w, h), fisheye))
