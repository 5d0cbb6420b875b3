"""Options that several commands share, and values that are checked while the command line is read."""

from __future__ import annotations

from typing import Annotated, NamedTuple

import typer

Json = Annotated[bool, typer.Option("--json", help="Print one JSON document, for programs.")]
DryRun = Annotated[bool, typer.Option("--dry-run", help="Change nothing; say what would be done.")]
Yes = Annotated[bool, typer.Option("--yes", "-y", help="Do not ask.")]


class Size(NamedTuple):
    """Width and height in one argument; of a plain tuple typer would read two."""

    width: int
    height: int


def parse_size(text: str | Size) -> Size:
    """Parse a size such as `1280x720`."""
    if isinstance(text, Size):
        return text
    width, _, height = text.partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise typer.BadParameter(f"{text} is not a size such as 1280x720")
    return Size(int(width), int(height))


def complete_plan(start: str) -> list[str]:
    """List the plans that begin with `start`."""
    from calibdb.access.plans import PLANS

    return [plan for plan in PLANS if plan.startswith(start)]


def complete_model(start: str) -> list[str]:
    """List the distortion models that begin with `start`."""
    from calibdb.schema import DISTORTION_MODELS

    return [model for model in DISTORTION_MODELS if model.startswith(start)]


def complete_reason(start: str) -> list[str]:
    """List the reasons of a withdrawal that the API returns."""
    return [reason for reason in ("wrong", "abuse", "privacy") if reason.startswith(start)]
