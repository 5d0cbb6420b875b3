"""Membership of a session in a rig, and moments."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, StringConstraints, model_validator
from pydantic_core import PydanticCustomError

from calibdb.schema.fields import CalibrationName, Open, Strict, Whole

MIN_RIG_CAMERAS, MAX_RIG_CAMERAS = 2, 8
MAX_MOMENT_LENGTH = 64  # characters

MomentId = Annotated[
    str,
    StringConstraints(pattern=rf"^[A-Za-z0-9_-]{{1,{MAX_MOMENT_LENGTH}}}$"),
    Field(description="Id of a moment: one pose of the board, held still, seen by several cameras."),
]
Position = Annotated[int, Field(strict=True, ge=0, lt=MAX_RIG_CAMERAS), Whole]


class RigJoin(Strict):
    """The rig that a session is to join: by its join code or by its id."""

    code: str | None = Field(None, max_length=32, description="Join code, six characters; case is ignored.")
    id: str | None = Field(None, max_length=64, description="Id of the rig, instead of a code.")
    position: Position | None = Field(None, description="The camera's position; the lowest free one.")

    @model_validator(mode="after")
    def _has_one_name(self) -> RigJoin:
        if (self.code is None) == (self.id is None):
            raise PydanticCustomError("one_of", "give either the code or the id of the rig")
        return self


class RigMembership(Open):
    """The rig of a session, and the position of its camera."""

    id: CalibrationName
    position: int
