"""Advice to the user about a whole capture."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from ..errors import CalibrationError, format_factor
from ..fitting.calibration import Calibration
from ..quality.model_selection import suggest_model
from ..view import View
from .consistency import thin


@dataclass(frozen=True)
class Advice:
    """A code for programs and an English sentence for people."""

    code: Literal[
        "prediction_disagrees",
        "limit_reached",
        "model_too_simple",
        "board_bent",
        "motion",
        "focus_changed",
    ]
    text: str


LIMIT_REACHED = Advice(
    "limit_reached",
    "So many views are in that more would hardly help; the error that was aimed for is not reached.",
)


def describe_disagreement(ratio: float | None, better_model: str | None) -> tuple[Advice, ...]:
    """Word the advice after a view that disagrees with the prediction.

    Parameters
    ----------
    ratio
        Actual / predicted error of the last view; None if the prediction held.
    better_model
        Model that explains the views better; None if there is none.
    """
    advice = []
    if ratio is not None:
        text = f"The last view lies {format_factor(ratio)} as far off as was predicted; more views will tell."
        advice.append(Advice("prediction_disagrees", text))
    if better_model is not None:
        text = f"This lens bends more than the model can; {better_model} explains it better."
        advice.append(Advice("model_too_simple", text))
    return tuple(advice)


def find_better_model(views: Sequence[View], calibration: Calibration) -> str | None:
    """Find the model that explains the views better than that of their `calibration`; None if none does."""
    if len(views) < 3:
        return None
    try:
        model = suggest_model([thin(view) for view in views], calibration.camera.img_size).model
    except CalibrationError:
        return None
    return model if model != calibration.camera.model else None
