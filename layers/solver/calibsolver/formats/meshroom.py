"""Intrinsics of Meshroom (AliceVision): of its .sfm files, and of the older .json ones."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from . import text
from .base import ImportedFile
from .coefficients import camera_from_opencv, matrix_of
from .members import Members

_RADIAL = ("none", "pinhole", "radial1", "radial3", "radialk1", "radialk3", "brown", "fisheye", "fisheye4")


def is_intrinsic(members: Members) -> bool:
    """True if a mapping is an intrinsic."""
    has_px = "pxfocallength" in members
    has_focal = has_px or ("focallength" in members and "sensorwidth" in members)
    is_new = has_focal and "distortionparams" in members and "width" in members
    return is_new or (has_px and "principalpoint" in members)


def _pair(value: object) -> object:
    return [value.get("x"), value.get("y")] if isinstance(value, Mapping) else value


def read(data: Mapping[Any, Any]) -> ImportedFile:
    """Read one intrinsic; CalibrationError ``malformed``.

    Source: AliceVision, `sfmDataIO/jsonIO.cpp`. Lengths are px or millimetres of the sensor's width; since
    version 1.2 of the file the principal point is an offset from the middle of the image.
    """
    members = Members(data)
    w, h = size = text.width_height((members.get("width"), members.get("height")))
    focal = text.floats(_pair(members.get("pxfocallength") or []), "pxFocalLength", 0, 2)
    if not len(focal):
        sensor = text.scalar(members.get("sensorwidth"), "sensorWidth")
        length = text.scalar(members.get("focallength"), "focalLength")
        ratio = text.scalar(members.get("pixelratio") or 1.0, "pixelRatio")
        if not sensor > 0 or ratio != 1:
            raise text.refuse("sensorWidth must be positive, and pixelRatio 1")
        focal = np.array([length / sensor * w])
    centre = text.floats(_pair(members.get("principalpoint") or [0, 0]), "principalPoint", 2, 2)
    middle = np.array([w, h]) / 2
    if (np.abs(centre) < 0.25 * middle).all():  # an offset: no principal point lies in a corner
        centre = centre + middle
    kind = str(members.get("distortiontype", "type") or "none").lower()
    d = text.floats(members.get("distortionparams") or [], "distortionParams", 0, 10)
    if kind not in _RADIAL:
        raise text.refuse(f"Meshroom's {kind[:40]!r} is not supported; radial, Brown and fisheye4 are")
    matrix = matrix_of(focal[0], focal[-1], centre[0] - 0.5, centre[1] - 0.5)
    if kind in ("fisheye", "fisheye4"):
        return ImportedFile(camera_from_opencv(matrix, d, size, fisheye=True))
    if kind == "brown":  # k1 k2 k3 t1 t2
        k1, k2, k3, p1, p2 = np.concatenate([d, np.zeros(5)])[:5]
    else:
        (k1, k2, k3), p1, p2 = np.concatenate([d, np.zeros(3)])[:3], 0.0, 0.0
    return ImportedFile(camera_from_opencv(matrix, np.array([k1, k2, p1, p2, k3]), size, fisheye=False))
