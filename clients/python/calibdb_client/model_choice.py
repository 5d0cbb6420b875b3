"""Choice of the distortion model for a recording."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from .errors import CaptureError
from .key import AUTO, checked_model

if TYPE_CHECKING:
    from .recording import Recording

MIN_COVERED = 0.99
"""Share of the picture in the domain of a model that covers the picture."""


def chosen_model(recording: Recording, model: str) -> tuple[str, str | None]:
    """Return the model to use, and one that explains the views better or None.

    `AUTO` is the model that predicts held-out views best, among those whose domain covers the picture.

    Raises UsageError for an unknown model, CaptureError if no model fits.
    """
    from calibsolver import CalibrationError, fit
    from calibsolver.quality.model_selection import MAX_EQUAL_RATIO, simplicity_rank, suggest_model

    if model != AUTO:
        checked_model(model)
    try:
        views = recording.observations()
        size = recording.key.img_size
        choice = suggest_model(views, size)
        errors: Mapping[str, float] = {
            name: error for name, error in choice.held_out.items() if error is not None
        }

        def covers(name: str) -> bool:
            return fit(views, size, name, board_shape=False).camera.domain().covered >= MIN_COVERED

        best = choice.model
        if not covers(best):
            covering = [name for name in errors if name != best and covers(name)]
            if covering:
                least = min(errors[name] for name in covering)
                good = [name for name in covering if errors[name] <= MAX_EQUAL_RATIO * least]
                best = min(good, key=simplicity_rank)
    except (CalibrationError, ValueError) as error:
        if model != AUTO:
            return model, None  # the fit of that model says what is wrong
        raise CaptureError(f"the pictures determine no calibration: {error}") from None
    if model == AUTO:
        return best, None
    return model, best if best != model else None
