"""Corners seen in one frame."""

from pydantic import Field, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

from calibdb.schema.fields import MAX_CORNERS, CornerId, Point, Strict

MAX_VIEWS = 5  # of a lookup or check


class ObservedCorners(Strict):
    """One frame: the board corners seen."""

    ids: tuple[CornerId, ...] = Field(
        min_length=1, max_length=MAX_CORNERS, description="Ids of the board's corners."
    )
    points: tuple[Point, ...] = Field(min_length=1, max_length=MAX_CORNERS, description="px, one for each id")

    @field_validator("ids")
    @classmethod
    def _unique(cls, value: tuple[int, ...]) -> tuple[int, ...]:
        if len(set(value)) != len(value):
            raise PydanticCustomError("duplicate_ids", "a corner appears more than once")
        return value

    @field_validator("points")
    @classmethod
    def _one_for_each_id(cls, value: tuple[Point, ...], info: ValidationInfo) -> tuple[Point, ...]:
        ids = info.data.get("ids")  # absent if they were refused
        if ids is not None and len(ids) != len(value):
            raise PydanticCustomError(
                "count_differs", "{points} points for {ids} ids", {"points": len(value), "ids": len(ids)}
            )
        return value
