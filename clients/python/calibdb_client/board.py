"""Calibration boards: as the service describes them, their corners, and OpenCV's ChArUco board."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from .errors import MissingPackageError, UsageError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

KINDS = ("charuco", "chessboard", "aprilgrid")
APRILTAGS = tuple(f"DICT_APRILTAG_{family}" for family in ("16h5", "25h9", "36h10", "36h11"))
DICTIONARIES = (
    *(f"DICT_{n}X{n}_{count}" for n in (4, 5, 6, 7) for count in (50, 100, 250, 1000)),
    "DICT_ARUCO_ORIGINAL",
    *APRILTAGS,
)
DEFAULT_DICTIONARY = "DICT_4X4_50"
DEFAULT_TAGS = "DICT_APRILTAG_36h11"
DEFAULT_TAG_SPACING = 0.3
MIN_CORNERS = 6
"""Corners of a board, and of a view of it, that the service can judge."""


@dataclass(frozen=True)
class Board:
    """A flat board. Frame: x right, y down as it is seen upright; unit: one square, or one side of a tag.

    Of ChArUco boards and chessboards the inner corners are measured: the corner `id` is `row * (columns - 1)
    + column`, at `(column + 1, row + 1)`. An AprilGrid is numbered as Kalibr numbers it: tags row by row from
    the lower left, id = 4 * tag + corner, corners anticlockwise from the tag's lower left; corner 0 is the
    origin, so that y <= 0.

    Attributes
    ----------
    squares
        Columns and rows of squares; of an AprilGrid its tags.
    marker_ratio
        Side of a marker / side of a square (ChArUco).
    dictionary
        OpenCV's name of the dictionary of markers; of an AprilGrid an AprilTag family.
    legacy
        Layout of OpenCV before 4.6 (ChArUco).
    kind
        One of `KINDS`. The first square of a chessboard is black.
    inverted
        White where other boards are black.
    tag_spacing
        Gap between the tags of an AprilGrid / side of a tag.

    Raises UsageError for a board that cannot exist.
    """

    squares: tuple[int, int] = (9, 6)
    marker_ratio: float = 0.65
    dictionary: str = ""
    legacy: bool = False
    kind: str = "charuco"
    inverted: bool = False
    tag_spacing: float = DEFAULT_TAG_SPACING

    def __post_init__(self) -> None:
        columns, rows = (int(n) for n in self.squares)
        object.__setattr__(self, "squares", (columns, rows))
        if self.kind not in KINDS:
            raise UsageError(f"a board is one of {', '.join(KINDS)}, not {self.kind!r}")
        least, what = (1, "tags") if self.kind == "aprilgrid" else (3, "squares")
        if not (least <= columns <= 50 and least <= rows <= 50) or self.corner_count < MIN_CORNERS:
            raise UsageError(
                f"a board has {least} to 50 {what} a side and {MIN_CORNERS} corners, not {columns} x {rows}"
            )
        if not self.dictionary:
            usual = DEFAULT_TAGS if self.kind == "aprilgrid" else DEFAULT_DICTIONARY
            object.__setattr__(self, "dictionary", usual)
        allowed = APRILTAGS if self.kind == "aprilgrid" else DICTIONARIES
        if self.dictionary not in allowed:
            raise UsageError(f"a dictionary is one of {', '.join(allowed)}, not {self.dictionary!r}")
        if not 0.3 <= self.marker_ratio <= 0.95:
            raise UsageError(f"the marker ratio lies in 0.3 to 0.95, not {self.marker_ratio}")
        if not 0.05 <= self.tag_spacing <= 2:
            raise UsageError(f"the tag spacing lies in 0.05 to 2, not {self.tag_spacing}")

    def __str__(self) -> str:
        """Words for people, such as ``ChArUco, 9 x 6 squares, marker ratio 0.65, DICT_4X4_50``."""
        size = f"{self.squares[0]} x {self.squares[1]}"
        words = {
            "charuco": f"ChArUco, {size} squares, marker ratio {self.marker_ratio:g}, {self.dictionary}",
            "chessboard": f"chessboard, {size} squares",
            "aprilgrid": f"AprilGrid, {size} tags, spacing {self.tag_spacing:g}, {self.dictionary}",
        }[self.kind]
        return words + (", legacy" if self.legacy else "") + (", white on black" if self.inverted else "")

    @property
    def corner_count(self) -> int:
        """Number of corners that are measured."""
        columns, rows = self.squares
        return 4 * columns * rows if self.kind == "aprilgrid" else (columns - 1) * (rows - 1)

    @property
    def size(self) -> tuple[float, float]:
        """Width and height, board units."""
        w, h = self.squares
        gap = self.tag_spacing if self.kind == "aprilgrid" else 0.0
        return w + (w - 1) * gap, h + (h - 1) * gap

    @cached_property
    def places(self) -> NDArray[np.float64]:
        """Corners in order of their ids, (n, 2), board units."""
        import numpy as np

        if self.kind != "aprilgrid":
            row, column = np.divmod(np.arange(self.corner_count), self.squares[0] - 1)
            return np.stack([column + 1.0, row + 1.0], axis=1)
        tag, corner = np.divmod(np.arange(self.corner_count), 4)
        row, column = np.divmod(tag, self.squares[0])
        x = column * (1 + self.tag_spacing) + np.isin(corner, (1, 2))
        y = row * (1 + self.tag_spacing) + np.isin(corner, (2, 3))
        return np.stack([x, -y], axis=1)

    @cached_property
    def edge(self) -> NDArray[np.float64]:
        """The corners of the board's edge, clockwise from the top left, (4, 2), board units."""
        import numpy as np

        w, h = self.size
        top = -h if self.kind == "aprilgrid" else 0.0
        return np.array([[0, top], [w, top], [w, top + h], [0, top + h]])

    def record(self) -> dict[str, Any]:
        """Return the board as the members of a request; those that older services do not know if needed."""
        told: dict[str, Any] = {"squares": list(self.squares)}
        if self.kind == "charuco":
            told |= {"marker_ratio": self.marker_ratio, "dictionary": self.dictionary, "legacy": self.legacy}
        else:
            told["kind"] = self.kind
        if self.kind == "aprilgrid":
            told |= {"dictionary": self.dictionary, "tag_spacing": self.tag_spacing}
        return told | ({"inverted": True} if self.inverted else {})

    def markers(self) -> Any:
        """Return the `cv2.aruco.Dictionary` of the markers.

        Raises MissingPackageError without OpenCV, UsageError if it has too few markers.
        """
        cv2 = opencv()
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, self.dictionary))
        count = self.squares[0] * self.squares[1] // (1 if self.kind == "aprilgrid" else 2)
        if count > len(dictionary.bytesList):
            raise UsageError(
                f"this board needs {count} markers, {self.dictionary} has {len(dictionary.bytesList)}: "
                "choose a larger dictionary"
            )
        return dictionary

    def opencv(self) -> Any:
        """Return the `cv2.aruco.CharucoBoard`, one square = 1. Raises as `markers` does."""
        board = opencv().aruco.CharucoBoard(self.squares, 1.0, self.marker_ratio, self.markers())
        board.setLegacyPattern(self.legacy)
        return board

    def check_opencv(self) -> None:
        """Raise MissingPackageError without OpenCV, UsageError if the dictionary has too few markers."""
        if self.kind == "chessboard":
            opencv()
        else:
            self.markers()


def opencv() -> Any:
    """Return the module `cv2`. Raises MissingPackageError if it is not installed."""
    try:
        import cv2
    except ImportError:
        raise MissingPackageError("boards are drawn and found by OpenCV: pip install opencv-python") from None
    return cv2
