"""Calibration boards within the bounds of the service, and OpenCV's ChArUco board."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

import calibsolver
from calibsolver.arrays import Array
from calibsolver.board import CIRCLES, DICTIONARIES, KINDS

from .errors import MissingPackageError, UsageError

__all__ = ["APRILTAGS", "DICTIONARIES", "KINDS", "MIN_CORNERS", "Board", "opencv"]

APRILTAGS = tuple(name for name in DICTIONARIES if name.startswith("DICT_APRILTAG_"))
DEFAULT_DICTIONARY = "DICT_4X4_50"
DEFAULT_TAGS = "DICT_APRILTAG_36h11"
DESCRIBE_IT = "describe it by --kind, --squares, --marker-ratio and --dictionary"
MAX_SIDE = 50
"""Squares, or tags, along a side of a board that the service takes."""
MIN_MARKER_RATIO = 0.3
MIN_CORNERS = 6
"""Corners of a board, and of a view of it, that the service can judge."""


@dataclass(frozen=True)
class Board(calibsolver.Board):
    """A flat board: `calibsolver.Board` within the bounds of the service, with its frames, numbers and units.

    The dictionary of an AprilGrid is DICT_APRILTAG_36h11 by default.

    Raises UsageError for a board that cannot exist, or that the service does not take.
    """

    dictionary: str = ""

    def __post_init__(self) -> None:
        if not self.dictionary:
            usual = DEFAULT_TAGS if self.kind == "aprilgrid" else DEFAULT_DICTIONARY
            object.__setattr__(self, "dictionary", usual)
        try:
            super().__post_init__()
        except ValueError as error:
            raise UsageError(str(error)) from None
        columns, rows = self.squares
        if max(columns, rows) > MAX_SIDE or self.corner_count < MIN_CORNERS:
            raise UsageError(
                f"a board has at most {MAX_SIDE} squares or tags a side and {MIN_CORNERS} corners or more, "
                f"not {columns} x {rows}"
            )
        if self.marker_ratio < MIN_MARKER_RATIO:
            raise UsageError(f"the marker ratio lies in 0.3 to 0.95, not {self.marker_ratio}")

    def __str__(self) -> str:
        size = f"{self.squares[0]} x {self.squares[1]}"
        words = {
            "charuco": f"ChArUco, {size} squares, marker ratio {self.marker_ratio:g}, {self.dictionary}",
            "chessboard": f"chessboard, {size} squares",
            "circles": f"circles, {size}, diameter {self.marker_ratio:g}",
            "asymmetric_circles": f"asymmetric circles, {size}, diameter {self.marker_ratio:g}",
            "aprilgrid": f"AprilGrid, {size} tags, spacing {self.tag_spacing:g}, {self.dictionary}",
        }[self.kind]
        remarks = (self.legacy, "legacy"), (self.inverted, "white on black"), (self.surface, "on a screen")
        return ", ".join([words, *(remark for applies, remark in remarks if applies)])

    @property
    def places(self) -> Array:
        """Corners in order of their ids, (n, 2), board units."""
        return self.points[:, :2]

    @property
    def edge(self) -> Array:
        """Corners of the board's edge, clockwise from the top left, (4, 2), board units."""
        return self.outline[:, :2]

    def shape_sentence(self, figures: Mapping[str, Any] | None, square_mm: float | None) -> str | None:
        """Return a sentence on the bend and the print of the board; None if it was taken as drawn.

        It is in millimetres if the side of a square, or of a tag, is given.
        """
        from calibsolver.quality.report import board_sentence

        length = float(np.ptp(self.points, axis=0).max()) * square_mm if square_mm else None
        return board_sentence(figures, length)

    def record(self) -> dict[str, Any]:
        """Return the members of a request; those that older services do not know only if needed."""
        members: dict[str, Any] = {"squares": list(self.squares)}
        if self.kind in CIRCLES:
            members |= {"kind": self.kind, "marker_ratio": self.marker_ratio}
        elif self.kind == "charuco":
            members |= {
                "marker_ratio": self.marker_ratio,
                "dictionary": self.dictionary,
                "legacy": self.legacy,
            }
        else:
            members["kind"] = self.kind
        if self.kind == "aprilgrid":
            members |= {"dictionary": self.dictionary, "tag_spacing": self.tag_spacing}
        if self.surface:
            members["surface"] = self.surface
        return members | ({"inverted": True} if self.inverted else {})

    def markers(self) -> Any:
        """Return the `cv2.aruco.Dictionary` of the markers. Raises MissingPackageError without OpenCV."""
        cv2 = opencv()
        return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, self.dictionary))

    def opencv(self) -> Any:
        """Return the `cv2.aruco.CharucoBoard`, one square = 1. Raises as `markers` does."""
        board = opencv().aruco.CharucoBoard(self.squares, 1.0, self.marker_ratio, self.markers())
        board.setLegacyPattern(self.legacy)
        return board


def opencv(what: str = "boards are drawn and found") -> Any:
    """Return the module `cv2`. Raises MissingPackageError if it is not installed."""
    try:
        import cv2
    except ImportError:
        raise MissingPackageError(f"{what} by OpenCV: pip install opencv-python") from None
    return cv2
