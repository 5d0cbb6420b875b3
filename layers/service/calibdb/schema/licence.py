"""Licence under which a contributor gives views away."""

import datetime
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

from calibdb.schema.fields import Deferred

Licence = Literal["CC0-1.0"]  # SPDX identifier


def _date(text: str) -> str:
    try:
        same = datetime.date.fromisoformat(text).isoformat() == text
    except ValueError:
        same = False
    if not same:
        raise PydanticCustomError("date", "give the date of the text as YYYY-MM-DD")
    return text


LicenceVersion = Annotated[str, Field(max_length=10), AfterValidator(_date)]


class Licensed(Deferred):
    """Licence of a document with views. Views without one count, but are never published."""

    licence: Licence | None = Field(
        None,
        description="`CC0-1.0`: the contributor agreed that the views may be given away under CC0 1.0. null: "
        "they count in consensuses, and stay out of dumps.",
    )
    licence_version: LicenceVersion | None = Field(
        None,
        description="Date of the text that the contributor agreed to, `YYYY-MM-DD`, as in the terms.",
    )

    @field_validator("licence_version")
    @classmethod
    def _belongs_to_a_licence(cls, value: str | None, info: ValidationInfo) -> str | None:
        if value is not None and info.data.get("licence") is None:
            raise PydanticCustomError("no_licence", "a text of no licence: send `licence`, too")
        return value

    @property
    def consent(self) -> dict[str, str]:
        """Both fields, without those that are None."""
        fields = {"licence": self.licence, "licence_version": self.licence_version}
        return {name: value for name, value in fields.items() if value is not None}
