"""Which model suits a lens: the simplest that explains views it has not seen as well as any does."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from .. import models
from ..errors import CalibrationError
from ..fitting.calibration import Calibration
from ..fitting.fit import MIN_POINTS, fit
from ..phrasing import off
from ..view import View
from .cross_validation import HeldOut, held_out

PLAIN = ("rectilinear", "fisheye", "omnidirectional", "rational")
"""From what every tool understands to what has most coefficients; others follow."""
MARGIN = 1.03
"""Held-out error / the least, which is no reason for a less simple model."""


@dataclass(frozen=True)
class Choice:
    """A model and why.

    Attributes
    ----------
    model
        Name of the model to use.
    held_out
        px, cross-validated rms by model; None where the model cannot be fitted to these views.
    reasons
        In plain words, what spoke for it and against the others.
    """

    model: str
    held_out: Mapping[str, float | None]
    reasons: tuple[str, ...]


def suggest_model(views: Sequence[View], img_size: tuple[int, int]) -> Choice:
    """Choose the model for the lens that took `views`.

    By the error on views left out of the fit, every model on the same points: those that no model explains
    are taken out first. The simplest model wins whose error is within `MARGIN` of the least, or within one
    standard error of it over the views (Breiman et al., "Classification and Regression Trees", 1984, 3.4.3).

    Raises CalibrationError (`fit`'s reason) where no model fits.
    """
    fits: dict[str, Calibration] = {}
    refused: dict[str, CalibrationError] = {}
    for name in models.NAMES:
        try:
            fits[name] = fit(views, img_size, name)
        except CalibrationError as error:
            refused[name] = error
    if not fits:
        raise refused[models.NAMES[0]]
    tested = explained(views, list(fits.values()))
    scores: dict[str, HeldOut] = {}
    for name in fits:
        try:
            scores[name] = held_out(tested, img_size, name)
        except CalibrationError as error:
            refused[name] = error
    if not scores:
        raise refused[models.NAMES[0]]
    best = min(scores, key=lambda name: scores[name].rms)
    chosen = next(name for name in sorted(scores, key=simplicity) if close(scores[name], scores[best]))
    errors = {name: scores[name].rms if name in scores else None for name in models.NAMES}
    return Choice(chosen, errors, tuple(reasons(chosen, best, scores, refused, img_size)))


def simplicity(name: str) -> tuple[int, int]:
    """Order of models, the plainest first."""
    return (PLAIN.index(name) if name in PLAIN else len(PLAIN), models.get(name).size)


def explained(views: Sequence[View], fits: Sequence[Calibration]) -> list[View]:
    """Return the views without the points that none of several fits used."""
    out = []
    for i, view in enumerate(views):
        used = np.logical_or.reduce([c.used[i] for c in fits])
        if used.sum() >= MIN_POINTS:
            out.append(View(view.object_points[used], view.image_points[used]))
    return out


def close(one: HeldOut, best: HeldOut) -> bool:
    """Whether one model is as good as the best, as far as these views can tell."""
    if one.rms <= MARGIN * best.rms:
        return True
    # Logarithms: a view that a model cannot follow at all is one vote against it, not a large variance.
    worse = np.log(one.view_errors / best.view_errors)
    free = max(len(worse) - 1, 1)
    error = float(np.std(worse)) / np.sqrt(free)
    # Student's t, one-sided 5 %, to 0.05 from 3 degrees of freedom on.
    return bool(np.mean(worse) <= (1.645 + 2.1 / free) * error)


def reasons(
    chosen: str,
    best: str,
    scores: Mapping[str, HeldOut],
    refused: Mapping[str, CalibrationError],
    img_size: tuple[int, int],
) -> list[str]:
    """Say why, model by model."""
    width = img_size[0]
    found = [f"views left out of the fit of {chosen} are {off(scores[chosen].rms, width, 2)}"]
    for name, result in scores.items():
        if name == chosen:
            continue
        told = off(result.rms, width, 2)
        if simplicity(name) < simplicity(chosen):
            found.append(f"{name} is simpler, but with it they are {told}")
        elif name == best and result.rms < scores[chosen].rms:
            found.append(f"with {name} they are {told}: not enough for a less simple model")
        else:
            found.append(f"{name} is no better: {told}")
    return found + [f"{name} does not fit: {error}" for name, error in refused.items()]
