"""The ChArUco board that a session's views show."""

from __future__ import annotations

from typing import Annotated, Literal, get_args

from pydantic import Field, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

from calibdb.schema.fields import Strict, Whole

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

# Two rows of corners need three rows of squares; one row of corners is a line, and a line fixes no pose.
SquareCount = Annotated[int, Field(strict=True, ge=3, le=50), Whole]


class Board(Strict):
    """A ChArUco board: squares with a marker in every white one.

    The corner `id` is `row * (squares_x - 1) + column`, counted over the inner corners.
    """

    squares: tuple[SquareCount, SquareCount] = Field((9, 6), description="Columns and rows of squares.")
    marker_ratio: float = Field(0.65, ge=0.3, le=0.95, description="Side of a marker over side of a square.")
    dictionary: Dictionary = Field("DICT_4X4_50", validate_default=True)
    legacy: bool = Field(False, description="Pattern as printed by OpenCV before 4.6.")

    @field_validator("squares")
    @classmethod
    def _has_corners_enough(cls, value: tuple[int, int]) -> tuple[int, int]:
        if (value[0] - 1) * (value[1] - 1) < MIN_CORNERS:
            raise PydanticCustomError(
                "too_few_corners", "a board has at least {least} inner corners", {"least": MIN_CORNERS}
            )
        return value

    @field_validator("dictionary")
    @classmethod
    def _holds_all_markers(cls, value: str, info: ValidationInfo) -> str:
        squares = info.data.get("squares")  # absent where it was refused itself
        markers = squares[0] * squares[1] // 2 if squares else 0
        if markers > (_MARKERS.get(value) or int(value.rpartition("_")[2])):
            raise PydanticCustomError(
                "dictionary_too_small",
                "a board of these squares has {markers} markers, more than the dictionary holds",
                {"markers": markers},
            )
        return value

    @property
    def corner_count(self) -> int:
        """Number of inner corners."""
        return (self.squares[0] - 1) * (self.squares[1] - 1)
