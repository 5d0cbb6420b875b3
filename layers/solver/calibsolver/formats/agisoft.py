"""Agisoft Metashape's calibration XML. Its centre is an offset; its P1 and P2 are OpenCV's p2 and p1."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from . import text
from .base import ImportedFile
from .coefficients import camera_from_opencv, matrix_of
from .members import Members


def is_calibration(members: Members) -> bool:
    """True if a mapping is a calibration."""
    return all(name in members for name in ("projection", "width", "height", "f"))


def is_sensor(members: Members) -> bool:
    """True if a mapping is a sensor of a whole document, with its calibrations."""
    return "calibration" in members and "resolution" in members


def read_sensor(data: Mapping[Any, Any]) -> ImportedFile:
    """Read the adjusted calibration of a sensor; CalibrationError ``malformed``.

    In a document the type of a calibration stands for its projection, and its size is that of the sensor.
    """
    members = Members(data)
    calibrations = members.get("calibration")
    several = calibrations if isinstance(calibrations, list) else [calibrations]
    parts = [dict(each) for each in several if isinstance(each, Mapping)]
    if not parts:
        raise text.refuse("the sensor has no calibration")
    chosen = next((c for c in parts if c.get("class") == "adjusted"), parts[-1])
    size = chosen.get("resolution") or members.get("resolution")
    if isinstance(size, Mapping):
        chosen |= {"width": Members(size).get("width"), "height": Members(size).get("height")}
    chosen.setdefault("projection", chosen.get("type", members.get("type") or "frame"))
    label = members.get("label")
    return replace(read(chosen), name=label if isinstance(label, str) else "")


def read(data: Mapping[Any, Any]) -> ImportedFile:
    """Read a parsed calibration; CalibrationError ``malformed``.

    Source: Agisoft Metashape user manual, appendix "Camera models". Pixels are counted from the image's
    corner.
    """
    members = Members(data)

    def value(name: str) -> float:
        return text.scalar(members.get(name) if name in members else 0.0, name)

    kind = str(members.get("projection")).lower()
    if kind not in ("frame", "fisheye"):
        raise text.refuse(f"the projection {kind[:40]!r} is not supported, frame and fisheye are")
    size = text.width_height((members.get("width"), members.get("height")))
    absent = ("b2", "k4") if kind == "frame" else ("b2", "p1", "p2")
    if any(map(value, absent)):
        raise text.refuse("skew (b2), k4 of a frame camera, or p1 and p2 of a fisheye are not supported")
    if value("p3") or value("p4"):
        raise text.refuse("p3 and p4 are not supported")
    if "fx" in members:  # versions before 1.1: the centre is a place
        fx, fy, cx, cy = value("fx"), value("fy"), value("cx") - 0.5, value("cy") - 0.5
    else:
        fy, cx, cy = value("f"), size[0] / 2 + value("cx") - 0.5, size[1] / 2 + value("cy") - 0.5
        fx = fy + value("b1")
    matrix = matrix_of(fx, fy, cx, cy)
    names = ("k1", "k2", "p2", "p1", "k3") if kind == "frame" else ("k1", "k2", "k3", "k4")
    return ImportedFile(
        camera_from_opencv(matrix, np.array([value(n) for n in names]), size, kind == "fisheye")
    )
