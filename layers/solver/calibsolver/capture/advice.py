"""What the user should know of a whole capture."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from ..errors import CalibrationError
from ..fitting.calibration import Calibration
from ..phrasing import times
from ..quality.model_selection import suggest_model
from ..view import View


@dataclass(frozen=True)
class Advice:
    """A code for programs, an English sentence for people."""

    code: Literal["prediction_disagrees", "model_too_simple", "limit_reached"]
    text: str


LIMIT = Advice(
    "limit_reached",
    "So many views are in that more would hardly help; the error that was aimed for is not reached.",
)


def disagreement(off: float | None, better: str | None) -> tuple[Advice, ...]:
    """Say that the last view was `off` times as far off as predicted, and which model is better."""
    said = []
    if off is not None:
        text = f"The last view lies {times(off)} as far off as was predicted; more views will tell."
        said.append(Advice("prediction_disagrees", text))
    if better is not None:
        text = f"This lens bends more than the model can; {better} explains it better."
        said.append(Advice("model_too_simple", text))
    return tuple(said)


def suggestion(views: Sequence[View], calibration: Calibration) -> str | None:
    """Return the model that explains the views better than that of their `calibration`, if one does."""
    if len(views) < 3:
        return None
    try:
        found = suggest_model(views, calibration.camera.img_size).model
    except CalibrationError:
        return None
    return found if found != calibration.camera.model else None
