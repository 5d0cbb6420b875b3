"""The board that a session's views show: ChArUco, chessboard or AprilGrid."""

from typing import Annotated, Literal, get_args

from pydantic import AfterValidator, Field, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError, PydanticKnownError

from calibdb.schema.fields import MAX_CORNERS, Strict, Whole

# fmt: off
Dictionary = Literal[
    "DICT_4X4_50", "DICT_4X4_100", "DICT_4X4_250", "DICT_4X4_1000",
    "DICT_5X5_50", "DICT_5X5_100", "DICT_5X5_250", "DICT_5X5_1000",
    "DICT_6X6_50", "DICT_6X6_100", "DICT_6X6_250", "DICT_6X6_1000",
    "DICT_7X7_50", "DICT_7X7_100", "DICT_7X7_250", "DICT_7X7_1000", "DICT_ARUCO_ORIGINAL",
    "DICT_APRILTAG_16h5", "DICT_APRILTAG_25h9", "DICT_APRILTAG_36h10", "DICT_APRILTAG_36h11",
]
# fmt: on
DICTIONARIES: tuple[str, ...] = get_args(Dictionary)
MIN_CORNERS = 6  # of a view that can be judged at all
_MARKERS = {  # of those whose name does not say it
    "DICT_ARUCO_ORIGINAL": 1024,
    "DICT_APRILTAG_16h5": 30,
    "DICT_APRILTAG_25h9": 35,
    "DICT_APRILTAG_36h10": 2320,
    "DICT_APRILTAG_36h11": 587,
}

BoardKind = Literal["charuco", "chessboard", "aprilgrid"]
MIN_SQUARES = {"charuco": 3, "chessboard": 3, "aprilgrid": 1}
"""Squares, or tags, per side: one row of corners fixes no pose."""
MAX_SQUARES = 50
DEFAULT_TAG_SPACING = 0.3


def _enough_squares(value: int, info: ValidationInfo) -> int:
    least = MIN_SQUARES[info.data.get("kind", "charuco")]  # absent if it was refused itself
    if value < least:
        raise PydanticKnownError("greater_than_equal", {"ge": least})
    return value


SquareCount = Annotated[int, Field(strict=True, ge=1, le=MAX_SQUARES), Whole, AfterValidator(_enough_squares)]


def _is_usual(value: str | bool | float | None) -> bool:
    return value in ("charuco", False, DEFAULT_TAG_SPACING, None)  # older records and clients lack the member


class Board(Strict):
    """A flat calibration board.

    `charuco`: squares with a marker in every white one. `chessboard`: only squares. The corner `id` of both
    is `row * (squares_x - 1) + column`, counted over the inner corners. `aprilgrid`: tags with a gap between
    them; `squares` counts tags, row by row from the lower left, and the corner `id` is `4 * tag + corner`,
    corners anticlockwise from the tag's lower left.
    """

    kind: BoardKind = Field("charuco", exclude_if=_is_usual, description="Kind of the board.")
    squares: tuple[SquareCount, SquareCount] = Field(
        (9, 6),
        description="Columns and rows of squares, 3 to 50 each; of an AprilGrid its tags, 1 to 50 each.",
    )
    marker_ratio: float = Field(
        0.65, ge=0.3, le=0.95, description="Side of a marker over side of a square (ChArUco)."
    )
    dictionary: Dictionary = Field(
        "DICT_4X4_50",
        validate_default=True,
        description="The markers' dictionary; of an AprilGrid an AprilTag family. A chessboard has none.",
    )
    legacy: bool = Field(False, description="Pattern as printed by OpenCV before 4.6 (ChArUco).")
    inverted: bool = Field(
        False, exclude_if=_is_usual, description="White where other boards are black, and black where white."
    )
    tag_spacing: float = Field(
        DEFAULT_TAG_SPACING,
        ge=0.05,
        le=2,
        exclude_if=_is_usual,
        description="Gap between the tags of an AprilGrid over side of a tag.",
    )
    surface: Literal["screen"] | None = Field(
        None,
        exclude_if=_is_usual,
        description="`screen`: a screen shows the board. It is flat and square, and no shape is estimated.",
    )

    @field_validator("squares")
    @classmethod
    def _has_corners_enough(cls, value: tuple[int, int], info: ValidationInfo) -> tuple[int, int]:
        kind = info.data.get("kind", "charuco")
        corners = _corner_count(kind, value)
        if corners < MIN_CORNERS:
            raise PydanticCustomError(
                "too_few_corners",
                "a board has at least {least} {what}",
                {"least": MIN_CORNERS, "what": "corners" if kind == "aprilgrid" else "inner corners"},
            )
        if corners > MAX_CORNERS:
            raise PydanticCustomError(
                "too_many_corners", "a board has at most {most} corners", {"most": MAX_CORNERS}
            )
        return value

    @field_validator("dictionary")
    @classmethod
    def _holds_all_markers(cls, value: str, info: ValidationInfo) -> str:
        kind, squares = info.data.get("kind"), info.data.get("squares")  # absent if they were refused
        if kind == "aprilgrid" and not value.startswith("DICT_APRILTAG_"):
            raise PydanticCustomError("no_tag_family", "the dictionary of an AprilGrid is an AprilTag family")
        if squares is None or kind in (None, "chessboard"):
            return value
        markers = squares[0] * squares[1] // (1 if kind == "aprilgrid" else 2)
        if markers > (_MARKERS.get(value) or int(value.rpartition("_")[2])):
            raise PydanticCustomError(
                "dictionary_too_small",
                "a board of these squares has {markers} markers, more than the dictionary holds",
                {"markers": markers},
            )
        return value

    @property
    def corner_count(self) -> int:
        """Number of measured corners."""
        return _corner_count(self.kind, self.squares)

    @property
    def is_half_turn_symmetric(self) -> bool:
        """True if it looks the same after half a turn, and therefore cannot link cameras."""
        return self.kind == "chessboard" and sum(self.squares) % 2 == 0


def _corner_count(kind: str, squares: tuple[int, int]) -> int:
    columns, rows = squares
    return 4 * columns * rows if kind == "aprilgrid" else (columns - 1) * (rows - 1)


DescribedBoard = Annotated[Board, Field(description="The board; default: a ChArUco board of 9 x 6 squares.")]
