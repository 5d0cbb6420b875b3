"""Values of a capture: the estimate after some views, exclusions of views, the decision about a view."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from ..errors import CalibrationError
from ..fitting.calibration import Calibration
from ..fitting.coverage import Coverage
from ..fitting.uncertainty import Uncertainty
from ..guidance.hints import Hint
from ..quality.model_selection import suggest_model
from ..quality.systematic import probable_cause
from ..view import View
from .admission import Reason
from .consistency import thin
from .ending import EndReason, History


@dataclass(frozen=True)
class Advice:
    """Advice to the user about a whole capture."""

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


def find_better_model(views: Sequence[View], calibration: Calibration) -> str | None:
    """Model that explains the views better than that of their `calibration`, or None."""
    model = calibration.camera.model
    if len(views) >= 3:
        with suppress(CalibrationError):
            model = suggest_model([thin(view) for view in views], calibration.camera.img_size).model
    return model if model != calibration.camera.model else None


@dataclass(frozen=True)
class Exclusion:
    """Exclusion of an accepted view from the fit."""

    reason: Literal["outlier", "disagrees"]
    detail: str

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> "Exclusion":
        """Exclusion of plain values: `reason`, `detail`."""
        return cls(record["reason"], record["detail"])


EXCLUDED_OUTLIER = Exclusion("outlier", "Views that came later show that its corners are wrong.")
EXCLUDED_MINORITY = Exclusion("disagrees", "More views agree with each other than with this one.")


REFUSAL_HINTS: Mapping[Reason, Hint] = {
    "too_few_points": Hint("show_more"),
    "degenerate": Hint("closer"),
    "mirrored": Hint("unmirror"),
    "outlier": Hint("hold_still"),
}
"""Hints that do not depend on the target."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """State of a capture after some views.

    Attributes
    ----------
    calibration
        Fitted to the views that are not excluded, in their order; None while no believable fit exists.
    view_errors
        px rms of each view, None without a calibration; of an excluded view, with only its pose fitted.
    uncertainty
        Predicted error of a projection over the image, px.
    progress
        0 to 1; 1 if converged. It may fall with a view that shows more noise than was seen before.
    end
        ``target``: at least `MIN_VIEWS` views are in, the predicted rms is below the target, and the last
        view was as far off as predicted; ``plateau``: the error has stopped falling although the views are
        held at their targets; ``limit``: `MAX_VIEWS` views, or as many points as count, are in;
        ``nothing_new``: only duplicates are shown; ``asked``: the user ended it; None: the capture continues.
    excluded
        By index of the view.
    suggested_model
        Model that explains the views if this one is too simple.
    coverage
        Part of the image that the board has shown, and the error there.
    """

    calibration: Calibration | None
    view_errors: tuple[float | None, ...]
    uncertainty: Uncertainty | None
    progress: float
    end: EndReason | None = None
    excluded: Mapping[int, Exclusion] = field(default_factory=dict)
    advice: tuple[Advice, ...] = ()
    suggested_model: str | None = None
    coverage: Coverage | None = None

    @property
    def converged(self) -> bool:
        """True if the capture ends here."""
        return self.end is not None

    def with_cause(self, views: Sequence[View]) -> "Estimate":
        """Estimate with the probable cause of systematic residuals as first advice, if it is noticeable.

        `views` are all views, also the excluded ones. A model that is suggested already stays the cause,
        unless another explains most of the residuals.
        """
        if self.calibration is None:
            return self
        active = [view for i, view in enumerate(views) if i not in self.excluded]
        try:
            cause = probable_cause(self.calibration, active)
        except CalibrationError:  # residuals that say nothing
            return self
        if cause is None or not cause.is_noticeable or (self.suggested_model and not cause.is_main):
            return self
        others = (advice for advice in self.advice if advice.code != "model_too_simple")
        advice = (Advice(cause.code, cause.text), *others)
        return replace(self, advice=advice, suggested_model=cause.model)


@dataclass(frozen=True, eq=False)
class ViewDecision:
    """Decision whether a view joins a capture.

    Attributes
    ----------
    on_target
        True if an accepted view was held at its target; None if there was no target.
    quarantine
        True if a refused view is worth keeping: it contradicts the others, which may be wrong.
    seed_rejected
        True if the seed did not pose this first view; the capture continues without it.
    """

    accepted: bool
    reason: Reason | None
    estimate: Estimate | None
    hint: Hint | None = None
    on_target: bool | None = None
    quarantine: bool = False
    seed_rejected: bool = False

    def after(self, history: History) -> History:
        """History of the capture after this decision."""
        if self.estimate is None:
            return replace(history, duplicates=history.duplicates + (self.reason == "duplicate"))
        u = self.estimate.uncertainty
        return history.with_view(bool(self.on_target), u.rms if u else None)
