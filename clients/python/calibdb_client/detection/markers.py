"""Markers of every dictionary in one picture: quadrilaterals, read once and looked up in all dictionaries."""

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from calibsolver.arrays import Array

from ..board import APRILTAGS, opencv
from .aprilgrid import BORDERS

FAMILIES = (*(f"DICT_{n}X{n}_1000" for n in (4, 5, 6, 7)), "DICT_ARUCO_ORIGINAL", *APRILTAGS)
"""Dictionaries whose markers differ: those with fewer markers are beginnings of them."""
CELL_PX = 6
"""Side of a marker's cell, as quadrilaterals are straightened to be read."""
WINDOW_SHARE, WINDOW_PX = 0.1, (2, 5)
"""Half the window in which a marker's corners are refined: of its side, and within px."""
MIN_CONTRAST = 30
"""Brightness, of 255, between the black and the white of a marker."""
Key = tuple[str, bool, bool]
"""Family, whether the markers are white on black, and whether the picture is mirrored."""


@dataclass(frozen=True, eq=False)
class Markers:
    """Markers of one family in one picture: ids (n,), each once, and corners (n, 4, 2) px, clockwise.

    Those of a mirrored picture are as in the picture turned back.
    """

    ids: Any
    corners: Array


def find_markers(grey: Any) -> dict[Key, Markers]:
    """Find the markers of all families in a picture (h, w)."""
    aruco = opencv().aruco
    detector = aruco.ArucoDetector(aruco.getPredefinedDictionary(aruco.DICT_4X4_50))
    by_key: dict[Key, dict[int, list[Array]]] = defaultdict(lambda: defaultdict(list))
    for inverted in (False, True):
        # White squares touch at their corners as black ones do: each colour is sought as black.
        dark = opencv().bitwise_not(grey) if inverted else grey
        corners, _, rejected = detector.detectMarkers(dark)
        for quad in (*corners, *rejected):
            corner = _outwards(np.asarray(quad, dtype=np.float64).reshape(4, 2))
            read = _read(dark, corner)
            corner = _refined(dark, corner) if read else corner
            for (family, mirrored), number in read.items():
                turned = (corner * [-1, 1] + [grey.shape[1] - 1, 0])[::-1] if mirrored else corner
                by_key[family, inverted, mirrored][number].append(turned)
    markers = {}
    for key, places in by_key.items():
        once = {number: quads[0] for number, quads in places.items() if len(quads) == 1}
        if once:
            markers[key] = Markers(np.array(list(once), dtype=np.int64), np.array(list(once.values())))
    return markers


def _outwards(quad: Array) -> Array:
    """Grow a quadrilateral (4, 2) px by half a pixel: contours run through its outermost pixels."""
    middle = quad.mean(axis=0)
    side = float(np.linalg.norm(quad - np.roll(quad, -1, axis=0), axis=1).mean())
    grown: Array = middle + (quad - middle) * (1 + 1 / max(side, 1.0))
    return grown


def _refined(grey: Any, quad: Array) -> Array:
    """Refine corners (4, 2) px, except those that have none near."""
    cv2 = opencv()
    side = float(np.linalg.norm(quad - np.roll(quad, -1, axis=0), axis=1).mean())
    half = int(np.clip(round(WINDOW_SHARE * side), *WINDOW_PX))
    fine = np.ascontiguousarray(quad, dtype=np.float32)[:, None].copy()
    cv2.cornerSubPix(grey, fine, (half, half), (-1, -1), (3, 20, 0.01))  # by count and by change
    refined = fine[:, 0].astype(np.float64)
    near = np.linalg.norm(refined - quad, axis=1) < half
    result: Array = np.where(near[:, None], refined, quad)
    return result


def _read(grey: Any, quad: Array) -> dict[tuple[str, bool], int]:
    """Return the numbers of a dark quadrilateral (4, 2) px as a marker, by family and mirroring."""
    cv2 = opencv()
    read: dict[tuple[str, bool], int] = {}
    for side, border in _sizes():
        count = side + 2 * border
        size = count * CELL_PX
        square = np.array([[0, 0], [size, 0], [size, size], [0, size]], dtype=np.float32) - 0.5
        matrix = cv2.getPerspectiveTransform(quad.astype(np.float32), square)
        straight = cv2.warpPerspective(grey, matrix, (size, size))
        inner = straight.reshape(count, CELL_PX, count, CELL_PX)[:, 1:-1, :, 1:-1]
        levels = inner.mean(axis=(1, 3))
        low, high = float(levels.min()), float(levels.max())
        if high - low < MIN_CONTRAST:
            return read
        white = levels > (low + high) / 2
        frame = np.ones((count, count), dtype=bool)
        frame[border:-border, border:-border] = False
        if white[frame].any():
            continue
        bits = white[border:-border, border:-border].astype(np.uint8)
        for mirrored in (False, True):
            cells = np.ascontiguousarray(bits[:, ::-1]) if mirrored else bits
            code = _turns(cv2.aruco.Dictionary.getByteListFromBits(cells)[0])[0]
            for family, number in _codes(side).get(code, {}).items():
                if border == 1 or family in APRILTAGS:
                    read[family, mirrored] = number
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
    """Return the code of a marker in its four rotations, in OpenCV's order."""
    return [each.tobytes() for each in np.ascontiguousarray(code).reshape(4, -1)]
