"""Model selection by cross-validation: the simplest model that is not significantly worse than the best."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from .. import models
from ..errors import CalibrationError, format_px_error, undetermined
from ..fitting.calibration import Calibration
from ..fitting.fit import fit
from ..fitting.validation import MIN_POINTS
from ..view import View
from .cross_validation import HeldOut, held_out

SIMPLEST_FIRST = ("rectilinear", "fisheye", "omnidirectional", "rational")
"""From what every tool understands to what has most coefficients."""
MAX_EQUAL_RATIO = 1.03
"""Held-out error / the least up to which two models count as equal."""
T_NORMAL, T_PER_FREEDOM = 1.645, 2.1
"""Quantile of Student's t, one-sided 5 %, is T_NORMAL + T_PER_FREEDOM / n to 0.05 from n = 3 degrees of
freedom on."""


@dataclass(frozen=True)
class Choice:
    """Model, and sentences why; `held_out`: px, cross-validated rms by model, None if it cannot be fitted."""

    model: str
    held_out: Mapping[str, float | None]
    reasons: tuple[str, ...]


@undetermined()
def suggest_model(views: Sequence[View], img_size: tuple[int, int]) -> Choice:
    """Choose the model for the lens that took `views`.

    The criterion is the error on views left out of the fit, without points that no model explains. The
    simplest model wins whose error is within `MAX_EQUAL_RATIO` of the least, or is not significantly worse
    by a paired t test on the logarithms of the views' errors, one-sided at 5 % (Student, "The probable
    error of a mean", 1908). Raises CalibrationError (`fit`'s reason) if no model fits.
    """
    fits: dict[str, Calibration] = {}
    refused: dict[str, CalibrationError] = {}
    for name in models.NAMES:
        try:
            fits[name] = fit(views, img_size, name, board_shape=False)
        except CalibrationError as error:
            refused[name] = error
    if not fits:
        raise refused[models.NAMES[0]]
    tested = without_outliers(views, list(fits.values()))
    scores: dict[str, HeldOut] = {}
    for name in fits:
        try:
            scores[name] = held_out(tested, img_size, name, board_shape=False)
        except CalibrationError as error:
            refused[name] = error
    if not scores:
        raise refused[models.NAMES[0]]
    best = min(scores, key=lambda name: scores[name].rms)
    chosen = next(
        name
        for name in sorted(scores, key=simplicity_rank)
        if not_significantly_worse(scores[name], scores[best])
    )
    errors = {name: scores[name].rms if name in scores else None for name in models.NAMES}
    return Choice(chosen, errors, tuple(describe_reasons(chosen, best, scores, refused, img_size)))


def fit_other_models(
    calibration: Calibration, views: Sequence[View], board_shape: bool
) -> dict[str, Calibration]:
    """Fits of the models other than the calibration's that succeed."""
    fits = {}
    for name in models.NAMES:
        if name != calibration.camera.model:
            with suppress(CalibrationError):
                fits[name] = fit(views, calibration.camera.img_size, name, board_shape=board_shape)
    return fits


def simplicity_rank(name: str) -> int:
    """Rank of a model from simple to complex; an unknown one comes last."""
    return SIMPLEST_FIRST.index(name) if name in SIMPLEST_FIRST else len(SIMPLEST_FIRST)


def without_outliers(views: Sequence[View], fits: Sequence[Calibration]) -> list[View]:
    """Views without the points that none of several fits used, and with enough others."""
    out = []
    for i, view in enumerate(views):
        used = np.logical_or.reduce([c.used[i] for c in fits])
        if used.sum() >= MIN_POINTS:
            out.append(view.subset(used))
    return out


def not_significantly_worse(one: HeldOut, best: HeldOut) -> bool:
    """True if a model is as good as the best, within what these views show (see `suggest_model`)."""
    if one.rms <= MAX_EQUAL_RATIO * best.rms:
        return True
    # Logarithms: a view that a model cannot follow at all is one vote against it, not a large variance.
    worse = np.log(one.view_errors / best.view_errors)
    worse = worse[~np.isnan(worse)]  # degenerate views have no error
    freedom = max(len(worse) - 1, 1)
    standard_error = float(np.std(worse)) / np.sqrt(freedom)
    return bool(np.mean(worse) <= (T_NORMAL + T_PER_FREEDOM / freedom) * standard_error)


def describe_reasons(
    chosen: str,
    best: str,
    scores: Mapping[str, HeldOut],
    refused: Mapping[str, CalibrationError],
    img_size: tuple[int, int],
) -> list[str]:
    """Sentences why a model was chosen, model by model."""
    width = img_size[0]
    sentences = [f"views left out of the fit of {chosen} are {format_px_error(scores[chosen].rms, width, 2)}"]
    for name, result in scores.items():
        if name == chosen:
            continue
        error = format_px_error(result.rms, width, 2)
        if simplicity_rank(name) < simplicity_rank(chosen):
            sentences.append(f"{name} is simpler, but with it they are {error}")
        elif name == best and result.rms < scores[chosen].rms:
            sentences.append(f"with {name} they are {error}: not enough for a less simple model")
        else:
            sentences.append(f"{name} is not better: {error}")
    return sentences + [f"{name} does not fit: {why}" for name, why in refused.items()]
