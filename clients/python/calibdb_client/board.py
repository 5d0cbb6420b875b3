"""The ChArUco board: its description as the service takes it, and as OpenCV's."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .errors import MissingPackageError, UsageError

_APRILTAGS = ("16h5", "25h9", "36h10", "36h11")
DICTIONARIES = (
    *(f"DICT_{n}X{n}_{count}" for n in (4, 5, 6, 7) for count in (50, 100, 250, 1000)),
    "DICT_ARUCO_ORIGINAL",
    *(f"DICT_APRILTAG_{family}" for family in _APRILTAGS),
)


@dataclass(frozen=True)
class Board:
    """A ChArUco board. The corner `id` is `row * (columns - 1) + column`, counted over the inner corners.

    Attributes
    ----------
    squares
        Columns and rows of squares.
    marker_ratio
        Side of a marker / side of a square.
    dictionary
        OpenCV's name of the dictionary of markers.
    legacy
        Layout of OpenCV before 4.6.

    Raises UsageError for a board that cannot exist.
    """

    squares: tuple[int, int] = (9, 6)
    marker_ratio: float = 0.65
    dictionary: str = "DICT_4X4_50"
    legacy: bool = False

    def __post_init__(self) -> None:
        columns, rows = (int(n) for n in self.squares)
        if not (3 <= columns <= 50 and 3 <= rows <= 50) or (columns - 1) * (rows - 1) < 6:
            raise UsageError(
                f"a board has 3 to 50 squares a side and six inner corners, not {columns} x {rows}"
            )
        if not 0.3 <= self.marker_ratio <= 0.95:
            raise UsageError(f"the marker ratio lies in 0.3 to 0.95, not {self.marker_ratio}")
        if self.dictionary not in DICTIONARIES:
            raise UsageError(f"a dictionary is one of {', '.join(DICTIONARIES)}, not {self.dictionary!r}")
        object.__setattr__(self, "squares", (columns, rows))

    @property
    def corner_count(self) -> int:
        """Number of inner corners."""
        return (self.squares[0] - 1) * (self.squares[1] - 1)

    def record(self) -> dict[str, Any]:
        """Return the board as the members of a request."""
        return {
            "squares": list(self.squares),
            "marker_ratio": self.marker_ratio,
            "dictionary": self.dictionary,
            "legacy": self.legacy,
        }

    def opencv(self) -> Any:
        """Return the `cv2.aruco.CharucoBoard`, one square = 1.

        Raises MissingPackageError without OpenCV, UsageError if the dictionary has too few markers.
        """
        try:
            import cv2
        except ImportError:
            raise MissingPackageError(
                "boards are drawn and found by OpenCV: pip install opencv-python"
            ) from None
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, self.dictionary))
        markers = self.squares[0] * self.squares[1] // 2
        if markers > len(dictionary.bytesList):
            raise UsageError(
                f"this board needs {markers} markers, {self.dictionary} has {len(dictionary.bytesList)}: "
                "choose a larger dictionary"
            )
        board = cv2.aruco.CharucoBoard(self.squares, 1.0, self.marker_ratio, dictionary)
        board.setLegacyPattern(self.legacy)
        return board
