"""Markers of every dictionary in one picture: quadrilaterals, read once and looked up in all dictionaries."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ..board import APRILTAGS, opencv
from ..projection import Array
from .aprilgrid import BORDERS

FAMILIES = (*(f"DICT_{n}X{n}_1000" for n in (4, 5, 6, 7)), "DICT_ARUCO_ORIGINAL", *APRILTAGS)
"""Dictionaries whose markers differ: those with fewer markers are beginnings of them."""
CELL_PX = 6
"""Side of a marker's cell, as quadrilaterals are straightened to be read."""
MIN_CONTRAST = 30
"""Brightness, of 255, between the black and the white of a marker."""
Key = tuple[str, bool]
"""Family, and whether the markers are white on black."""


@dataclass(frozen=True, eq=False)
class Markers:
    """Markers of one family in one picture.

    Attributes
    ----------
    ids
        (n,), each once.
    corners
        (n, 4, 2) px, clockwise.
    """

    ids: Any
    corners: Array


def find_markers(grey: Any) -> dict[Key, Markers]:
    """Find the markers of all families in a picture (h, w), by family and colour."""
    aruco = opencv().aruco
    detector = aruco.ArucoDetector(aruco.getPredefinedDictionary(aruco.DICT_4X4_50))
    corners, _, rejected = detector.detectMarkers(grey)
    found: dict[Key, dict[int, list[Array]]] = defaultdict(lambda: defaultdict(list))
    for quad in (*corners, *rejected):
        corner = np.asarray(quad, dtype=np.float64).reshape(4, 2)
        for key, number in _read(grey, corner).items():
            found[key][number].append(corner)
    markers = {}
    for key, places in found.items():
        once = {number: quads[0] for number, quads in places.items() if len(quads) == 1}
        if once:
            markers[key] = Markers(np.array(list(once), dtype=np.int64), np.array(list(once.values())))
    return markers


def _read(grey: Any, quad: Array) -> dict[Key, int]:
    """Return the number of a quadrilateral (4, 2) px in every family in which it is a marker."""
    cv2 = opencv()
    read: dict[Key, int] = {}
    for side, border in _sizes():
        cells = side + 2 * border
        size = cells * CELL_PX
        square = np.array([[0, 0], [size, 0], [size, size], [0, size]], dtype=np.float32) - 0.5
        matrix = cv2.getPerspectiveTransform(quad.astype(np.float32), square)
        straight = cv2.warpPerspective(grey, matrix, (size, size))
        inner = straight.reshape(cells, CELL_PX, cells, CELL_PX)[:, 1:-1, :, 1:-1]
        levels = inner.mean(axis=(1, 3))
        low, high = float(levels.min()), float(levels.max())
        if high - low < MIN_CONTRAST:
            return read
        white = levels > (low + high) / 2
        frame = np.ones((cells, cells), dtype=bool)
        frame[border:-border, border:-border] = False
        inverted = bool(white[frame].mean() > 0.5)
        if (white[frame] != inverted).any():
            continue
        bits = (white != inverted)[border:-border, border:-border].astype(np.uint8)
        code = _turns(cv2.aruco.Dictionary.getByteListFromBits(bits)[0])[0]
        for family, number in _codes(side).get(code, {}).items():
            if border == 1 or family in APRILTAGS:
                read[family, inverted] = number
    return read


@lru_cache(maxsize=1)
def _sizes() -> tuple[tuple[int, int], ...]:
    """Sides of the markers of all families, and widths of their borders, cells."""
    aruco = opencv().aruco
    sizes = set()
    for family in FAMILIES:
        side = int(aruco.getPredefinedDictionary(getattr(aruco, family)).markerSize)
        sizes |= {(side, border) for border in (BORDERS if family in APRILTAGS else (1,))}
    return tuple(sorted(sizes))


@lru_cache(maxsize=8)
def _codes(side: int) -> Mapping[bytes, Mapping[str, int]]:
    """Numbers by family of the codes of markers with so many cells a side, however they are turned."""
    aruco = opencv().aruco
    codes: dict[bytes, dict[str, int]] = defaultdict(dict)
    for family in FAMILIES:
        dictionary = aruco.getPredefinedDictionary(getattr(aruco, family))
        if dictionary.markerSize != side:
            continue
        for number, code in enumerate(np.asarray(dictionary.bytesList)):
            for turn in _turns(code):
                codes[turn][family] = number
    return codes


def _turns(code: Any) -> list[bytes]:
    """Return the code of a marker in its four turns, which OpenCV keeps one after the other."""
    return [each.tobytes() for each in np.ascontiguousarray(code).reshape(4, -1)]
