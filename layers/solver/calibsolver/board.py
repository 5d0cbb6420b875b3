"""The ChArUco board: its corners, and its picture's parameters."""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from .arrays import Array, frozen
from .view import View

DICTIONARIES = {
    **{f"DICT_{n}X{n}_{count}": count for n in (4, 5, 6, 7) for count in (50, 100, 250, 1000)},
    "DICT_ARUCO_ORIGINAL": 1024,
    "DICT_APRILTAG_16h5": 30,
    "DICT_APRILTAG_25h9": 35,
    "DICT_APRILTAG_36h10": 2320,
    "DICT_APRILTAG_36h11": 587,
}


@dataclass(frozen=True)
class Board:
    """A ChArUco board; unit of length = one square.

    Frame: x right, y down, z away from the viewer; a board that faces the camera upright has rotation 0.
    Corner id = row * (squares_x - 1) + column lies at (column + 1, row + 1, 0), as in OpenCV.

    Attributes
    ----------
    squares
        (columns, rows), 3 to 64 each.
    marker_ratio
        Side of a marker / side of a square, inside (0, 1).
    dictionary
        OpenCV's name: ``DICT_<n>X<n>_<count>``, ``DICT_ARUCO_ORIGINAL`` or ``DICT_APRILTAG_<family>``.
    legacy
        The layout of OpenCV before 4.6: where the number of rows is even, the first square holds a marker.

    Raises ValueError for a board that cannot exist.
    """

    squares: tuple[int, int] = (9, 6)
    marker_ratio: float = 0.65
    dictionary: str = "DICT_4X4_50"
    legacy: bool = False

    def __post_init__(self) -> None:
        w, h = (int(n) for n in self.squares)
        if (w, h) != tuple(self.squares):
            raise ValueError(f"squares are two whole numbers, not {self.squares}")
        object.__setattr__(self, "squares", (w, h))
        if not (3 <= w <= 64 and 3 <= h <= 64):
            raise ValueError(f"a board has 3 to 64 squares a side, not {w} x {h}")
        if not 0.1 <= self.marker_ratio <= 0.95:
            raise ValueError(f"marker_ratio must lie in 0.1 to 0.95, not {self.marker_ratio}")
        if self.dictionary not in DICTIONARIES:
            raise ValueError(f"unknown dictionary {self.dictionary!r}")
        if w * h // 2 > DICTIONARIES[self.dictionary]:
            raise ValueError(f"{w} x {h} squares need {w * h // 2} markers, {self.dictionary} has fewer")

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> "Board":
        """Board of plain values under the names of its attributes; missing ones have their defaults.

        Raises ValueError for a board that cannot exist.
        """
        values = dict(record)
        if "squares" in values:
            w, h = values["squares"]
            values["squares"] = (w, h)
        return cls(**values)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in squares."""
        return self.squares

    @property
    def corner_count(self) -> int:
        """Number of inner corners."""
        return (self.squares[0] - 1) * (self.squares[1] - 1)

    @cached_property
    def points(self) -> Array:
        """Inner corners in order of their ids, (n, 3), squares, board frame."""
        w = self.squares[0]
        row, column = np.divmod(np.arange(self.corner_count), w - 1)
        return frozen(np.stack([column + 1, row + 1, np.zeros(self.corner_count)], axis=1))

    @cached_property
    def outline(self) -> Array:
        """The four corners of the board's edge, clockwise from the top left, (4, 3), squares, board frame."""
        w, h = self.squares
        return frozen([[0, 0, 0], [w, 0, 0], [w, h, 0], [0, h, 0]])

    @property
    def marker_size(self) -> int:
        """Cells along a marker's side, without its border."""
        if bits := re.match(r"DICT_APRILTAG_(\d+)h", self.dictionary):
            return math.isqrt(int(bits.group(1)))
        match = re.match(r"DICT_(\d)X", self.dictionary)
        return int(match.group(1)) if match else 5

    def view(self, ids: Sequence[int], points: object) -> View:
        """Return the view in which the corners `ids` (n) were seen at `points` (n, 2) px.

        Raises ValueError for an id that is not on the board or is given twice.
        """
        given = np.asarray(ids).reshape(-1)
        index = given.astype(np.int64)
        if (index != given).any():
            raise ValueError("corner ids are whole numbers")
        if index.size and (index.min() < 0 or index.max() >= self.corner_count):
            raise ValueError(f"corner ids run from 0 to {self.corner_count - 1}")
        if len(np.unique(index)) != len(index):
            raise ValueError("a corner id is given twice")
        return View(self.points[index], np.asarray(points, dtype=np.float64).reshape(-1, 2))

    def views(self, records: Iterable[Mapping[str, Any]]) -> list[View]:
        """Build views of records of plain values: `ids` (n), `points` (n, 2) px; other members are ignored.

        Raises ValueError as `view` does.
        """
        return [self.view(record["ids"], record["points"]) for record in records]
