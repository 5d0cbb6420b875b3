"""Feedback of a capture: what the person sees, hears and may press."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, Protocol

from calibsolver.arrays import Array

from .guide import Status, Target

Command = Literal["", "skip", "stop"]


@dataclass(frozen=True, eq=False)
class Scene:
    """State of a capture at one frame.

    Attributes
    ----------
    points
        (n, 2) px, corners seen; None: the board is not in sight.
    target
        None while the service is asked.
    hold
        0 to 1, part of the time for which the board must be held still.
    """

    picture: Any
    points: Array | None
    target: Target | None
    instruction: str
    hold: float
    status: Status


class Feedback(Protocol):
    """Interface of the feedback to the user during a capture."""

    def show(self, scene: Scene) -> Command:
        """Show one frame's state, and return what the person wants."""

    def taken(self, status: Status) -> None:
        """Tell that a view was taken."""

    def note(self, text: str) -> None:
        """Tell a sentence."""

    def close(self) -> None:
        """End."""


class Silent:
    """Feedback without output."""

    def show(self, scene: Scene) -> Command:
        """Show nothing."""
        del scene
        return ""

    def taken(self, status: Status) -> None:
        """Tell nothing."""

    def note(self, text: str) -> None:
        """Tell nothing."""

    def close(self) -> None:
        """End."""


def progress_words(status: Status) -> str:
    """Describe the course, such as ``3 views, 62 %, 0.41 px``."""
    views = f"{status.views} view{'' if status.views == 1 else 's'}"
    error = "" if status.error is None else f", {status.error:.2f} px"
    return f"{views}, {100 * status.progress:.0f} %{error}"
