"""Calibration boards: their corners, and the parameters of their pictures."""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from .arrays import Array, IntArray, frozen
from .view import View

DICTIONARIES = {
    **{f"DICT_{n}X{n}_{count}": count for n in (4, 5, 6, 7) for count in (50, 100, 250, 1000)},
    "DICT_ARUCO_ORIGINAL": 1024,
    "DICT_APRILTAG_16h5": 30,
    "DICT_APRILTAG_25h9": 35,
    "DICT_APRILTAG_36h10": 2320,
    "DICT_APRILTAG_36h11": 587,
}


SURFACES = (None, "screen")
KINDS = ("charuco", "chessboard", "aprilgrid", "circles", "asymmetric_circles")
CIRCLES = ("circles", "asymmetric_circles")
"""Kinds of boards of circles; `marker_ratio` is a circle's diameter / the unit."""


@dataclass(frozen=True)
class Board:
    """A flat calibration board; unit of length = one square, of an AprilGrid one side of a tag.

    Frame: x right, y down, z away from the viewer; a board that faces the camera upright has rotation 0.
    Corner id = row * (squares_x - 1) + column lies at (column + 1, row + 1, 0), as in OpenCV.

    AprilGrid, as Kalibr: tags row by row from the lower left one, id = 4 * tag + corner, corners
    anticlockwise from the lower left of the tag. Corner 0 is the origin, so that y <= 0.

    Circles: row by row from the upper left, circle 0 at (1, 1), the unit is the distance between rows. In an
    asymmetric grid the circles of a row are two units apart, and odd rows are shifted by one.

    Attributes
    ----------
    squares
        (columns, rows), 3 to 64 each; tags, 1 to 64, or circles, 2 to 64.
    marker_ratio
        Side of a marker / side of a square, inside (0, 1).
    dictionary
        OpenCV's name: ``DICT_<n>X<n>_<count>``, ``DICT_ARUCO_ORIGINAL`` or ``DICT_APRILTAG_<family>``.
    legacy
        The layout of OpenCV before 4.6: if the number of rows is even, the first square has a marker.
    kind
        One of `KINDS`. A chessboard has no markers; its first square is black.
    inverted
        White where other boards are black.
    tag_spacing
        Gap between the tags of an AprilGrid / side of a tag.
    surface
        ``screen`` if a screen shows the board, which is flat then.

    Raises ValueError for a board that cannot exist.
    """

    squares: tuple[int, int] = (9, 6)
    marker_ratio: float = 0.65
    dictionary: str = "DICT_4X4_50"
    legacy: bool = False
    kind: str = "charuco"
    inverted: bool = False
    tag_spacing: float = 0.3
    surface: str | None = None

    def __post_init__(self) -> None:
        w, h = (int(n) for n in self.squares)
        if (w, h) != tuple(self.squares):
            raise ValueError(f"squares are two whole numbers, not {self.squares}")
        object.__setattr__(self, "squares", (w, h))
        if self.kind not in KINDS:
            raise ValueError(f"a board is one of {', '.join(KINDS)}, not {self.kind!r}")
        if self.surface not in SURFACES:
            raise ValueError(f"the surface of a board is 'screen' or None, not {self.surface!r}")
        least, what = {"aprilgrid": (1, "tags"), **dict.fromkeys(CIRCLES, (2, "circles"))}.get(
            self.kind, (3, "squares")
        )
        if not (least <= w <= 64 and least <= h <= 64):
            raise ValueError(f"a board has {least} to 64 {what} a side, not {w} x {h}")
        if not 0.1 <= self.marker_ratio <= 0.95:
            raise ValueError(f"marker_ratio must lie in 0.1 to 0.95, not {self.marker_ratio}")
        if self.dictionary not in DICTIONARIES:
            raise ValueError(f"unknown dictionary {self.dictionary!r}")
        if self.kind == "aprilgrid":
            if not self.dictionary.startswith("DICT_APRILTAG_"):
                raise ValueError(
                    f"the dictionary of an AprilGrid is an AprilTag family, not {self.dictionary!r}"
                )
            if not 0.05 <= self.tag_spacing <= 2:
                raise ValueError(f"tag_spacing must lie in 0.05 to 2 on this board, not {self.tag_spacing}")
            if w * h < 2:
                raise ValueError("a board needs two tags or more: four corners do not determine a camera")
        markers = {"charuco": w * h // 2, "aprilgrid": w * h}.get(self.kind, 0)
        if markers > DICTIONARIES[self.dictionary]:
            raise ValueError(
                f"{w} x {h} {what} need {markers} markers, {self.dictionary} has fewer: "
                "choose a larger dictionary"
            )

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> "Board":
        """Board of plain values under the names of its attributes; missing ones have their defaults."""
        values = dict(record)
        if "squares" in values:
            w, h = values["squares"]
            values["squares"] = (w, h)
        return cls(**values)

    @property
    def size(self) -> tuple[float, float]:
        """Width and height, board units."""
        if self.kind == "aprilgrid":
            w, h = (n + (n - 1) * self.tag_spacing for n in self.squares)
            return w, h
        if self.kind in CIRCLES:
            right, bottom = self.points[:, :2].max(axis=0).tolist()
            return right + 1, bottom + 1
        return self.squares

    @property
    def corner_count(self) -> int:
        """Number of corners that are measured."""
        return self.lattice.size

    @property
    def has_markers(self) -> bool:
        """True if a part of the board identifies itself; other boards must be visible as a whole."""
        return self.kind in ("charuco", "aprilgrid")

    @property
    def is_half_turn_symmetric(self) -> bool:
        """True if it looks the same after half a turn: sufficient for intrinsics, not for shared poses."""
        if self.kind == "asymmetric_circles":
            return self.squares[1] % 2 == 1
        return self.kind == "circles" or (self.kind == "chessboard" and sum(self.squares) % 2 == 0)

    @cached_property
    def lattice(self) -> IntArray:
        """Ids of the corners in rows and columns, (rows, columns), from the top left as the board is seen."""
        w, h = self.squares
        if self.kind != "aprilgrid":
            rows, columns = (h, w) if self.kind in CIRCLES else (h - 1, w - 1)
            return np.arange(rows * columns).reshape(rows, columns)
        tags = 4 * np.arange(w * h).reshape(h, w)[::-1]
        top, bottom = np.stack([tags + 3, tags + 2], axis=2), np.stack([tags, tags + 1], axis=2)
        return np.stack([top.reshape(h, 2 * w), bottom.reshape(h, 2 * w)], axis=1).reshape(2 * h, 2 * w)

    @cached_property
    def points(self) -> Array:
        """Corners in order of their ids, (n, 3), board units, board frame."""
        if self.kind == "aprilgrid":
            tag, corner = np.divmod(np.arange(4 * self.squares[0] * self.squares[1]), 4)
            row, column = np.divmod(tag, self.squares[0])
            x = column * (1 + self.tag_spacing) + np.isin(corner, (1, 2))
            y = row * (1 + self.tag_spacing) + np.isin(corner, (2, 3))
            return frozen(np.stack([x, -y, np.zeros(len(x))], axis=1))
        row, column = np.indices(self.lattice.shape).reshape(2, -1)
        if self.kind == "asymmetric_circles":
            column = 2 * column + row % 2
        return frozen(np.stack([column + 1, row + 1, np.zeros(len(row))], axis=1))

    @cached_property
    def support(self) -> Array:
        """Points that a camera must see for a detector to find each corner, (n, g, m, 3), board units.

        All m of one of g groups suffice: the corners of a marker next to the corner, those of the tag, the
        ends of a circle, or a chessboard's corner itself.
        """
        points = self.points[:, None, None]
        if self.kind == "aprilgrid":
            return frozen(np.repeat(self.points.reshape(-1, 1, 4, 3), 4, axis=1).reshape(-1, 1, 4, 3))
        if self.kind in CIRCLES:
            ends = np.array([[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0]])
            return frozen(points + self.marker_ratio / 2 * ends)
        if self.kind == "chessboard":
            return frozen(points)
        square = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
        below = 0.5 * np.array([1, 1, 0]) + self.marker_ratio / 2 * square
        falling = np.stack([-below, below])
        first_has_marker = self.legacy and self.squares[1] % 2 == 0
        is_falling = (self.points[:, :2].sum(axis=1) % 2 == 0) == first_has_marker
        return frozen(points + np.where(is_falling[:, None, None, None], falling, falling * [1, -1, 1]))

    @cached_property
    def outline(self) -> Array:
        """Corners of the board's edge, clockwise from the top left, (4, 3), board units and frame."""
        w, h = self.size
        top = -h if self.kind == "aprilgrid" else 0.0
        return frozen([[0, top, 0], [w, top, 0], [w, top + h, 0], [0, top + h, 0]])

    @property
    def marker_size(self) -> int:
        """Cells along a marker's side, without its border."""
        if bits := re.match(r"DICT_APRILTAG_(\d+)h", self.dictionary):
            return math.isqrt(int(bits.group(1)))
        match = re.match(r"DICT_(\d)X", self.dictionary)
        return int(match.group(1)) if match else 5

    def view(self, ids: Sequence[int], points: object) -> View:
        """View in which the corners `ids` (n) were seen at `points` (n, 2) px.

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
        seen = np.asarray(points, dtype=np.float64).reshape(-1, 2)
        return View(self.points[index], seen, flat=self.surface == "screen")

    def views(self, records: Iterable[Mapping[str, Any]]) -> list[View]:
        """Views of records of plain values, `ids` (n) and `points` (n, 2) px.

        Raises ValueError as `view` does.
        """
        return [self.view(record["ids"], record["points"]) for record in records]
