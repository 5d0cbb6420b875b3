"""How far a capture has come, and what became of a view."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from ..fitting.calibration import Calibration
from ..fitting.uncertainty import Uncertainty
from ..guidance.hints import Hint
from .admission import Reason
from .advice import Advice


@dataclass(frozen=True)
class SetAside:
    """Why an accepted view takes no part any more: a reason for programs, a sentence for people."""

    reason: Literal["outlier", "disagrees"]
    detail: str


OUTLIER = SetAside("outlier", "Views that came later show that its corners are wrong.")
DISAGREES = SetAside("disagrees", "More views agree with each other than with this one.")


@dataclass(frozen=True, eq=False)
class Estimate:
    """What is known after some views.

    Attributes
    ----------
    calibration
        Fitted to the views that are not set aside, in their order; None while no believable fit exists.
    view_errors
        px rms of each view, None without a calibration; of a view set aside, with its pose alone fitted.
    uncertainty
        Predicted error of a projection over the image, px.
    progress
        0 to 1; 1 where converged. It follows the predicted error and the number of views, so it grows with
        every view that brings information; it may fall with one that shows more noise than was seen before.
    converged
        Whether the capture ends here: four views are in and the predicted rms is below the target, the last
        view was as far off as predicted; or so many views are in that more would not help.
    aside
        Views set aside: index -> why.
    advice, suggested_model
        What the user should know; the model that explains the views where this one is too simple.
    """

    calibration: Calibration | None
    view_errors: tuple[float | None, ...]
    uncertainty: Uncertainty | None
    progress: float
    converged: bool
    aside: Mapping[int, SetAside] = field(default_factory=dict)
    advice: tuple[Advice, ...] = ()
    suggested_model: str | None = None


@dataclass(frozen=True, eq=False)
class Verdict:
    """Whether a view is taken.

    Attributes
    ----------
    accepted
        Whether it is; if so `estimate` counts it.
    reason, hint
        If not: why, and what to do.
    witness
        Whether a refused view is worth keeping: where it contradicts the others it may be they who are wrong.
    """

    accepted: bool
    reason: Reason | None
    estimate: Estimate | None
    hint: Hint | None = None
    witness: bool = False
