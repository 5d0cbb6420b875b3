"""Quality report of a calibration: the figures that a page shows."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias, Union

import numpy as np

from ..arrays import Array
from ..errors import undetermined
from ..fitting.board_shape import BoardShape
from ..fitting.calibration import Calibration
from ..view import View
from .assessment import Reason, assess
from .systematic import probable_cause

_PRINT: Mapping[str | None, str] = {
    "wider": "{} wider than drawn",
    "narrower": "{} narrower than drawn",
    "skewed": "skewed by {}",
    None: "{} out of shape",
}
"""Words by `BoardShape.stretch_kind`; older records have none."""
MIN_CERTAIN_SIGMAS = 2.0
"""Sag or stretch / its standard deviation above which it is certain."""
Json: TypeAlias = Union["dict[str, Json]", "list[Json]", str, bool, int, float, None]


@undetermined()
def describe(
    calibration: Calibration,
    views: Sequence[View],
    indices: Sequence[int] | None = None,
    held_out: float | None = None,
) -> dict[str, Json]:
    """Describe a calibration for a page that shows it: plain JSON values, rounded to what they carry.

    Parameters
    ----------
    indices
        The views' names in the capture they come from; by default counted from 0.
    held_out
        px, rms of a cross-validation.

    Returns
    -------
    ``verdict`` (level; reasons, the one to act on first), ``board`` (`BoardShape.figures`; null: as drawn),
    ``std`` and ``covariance`` (p, p) of the intrinsics, ``error_map`` (predicted projection error over the
    image, px, null where the model has no ray), ``held_out`` (null also if it is more than the image is
    wide), ``systematic`` (``inflation``; probable ``cause``, what to do in ``text``, the ``model`` to
    choose), ``views``: per view its ``index``, ``rms`` (px), ``points`` (px), ``residuals`` (measured minus
    predicted, px), ``rvec``, ``tvec`` (board -> camera), ``cut`` (numbers of the points left out), ``reason``
    (why the whole view was left out). A degenerate view has neither pose nor error: null.
    """
    verdict = assess(calibration, views, held_out)
    cause = probable_cause(calibration, views)
    shape = calibration.board_shape
    reasons = verdict.reasons
    if cause is not None and cause.is_noticeable:  # replaces the suspicion of the model
        reasons = (
            *(each for each in reasons if each.code != "model_too_simple"),
            Reason(cause.code, cause.text),
        )
    level = "fair" if verdict.level == "good" and reasons else verdict.level
    std = np.sqrt(np.maximum(np.diagonal(calibration.covariance), 0))
    grid, width = (20, 15), calibration.camera.img_size[0]
    return {
        "verdict": {"level": level, "reasons": [{"code": r.code, "text": r.text} for r in reasons]},
        "board": None if shape is None else _board(shape),
        "std": {
            **{name: _digits(value) for name, value in zip(("fx", "fy", "cx", "cy"), std, strict=False)},
            "distortion": [_digits(value) for value in std[4:]],
        },
        "covariance": calibration.covariance.tolist(),
        "systematic": {
            "inflation": _digits(calibration.inflation),
            "cause": cause.code if cause else None,
            "text": cause.text if cause else None,
            "model": cause.model if cause else None,
        },
        "error_map": {"grid": list(grid), "px": _to_lists(calibration.projection_std(grid), _digits)},
        "held_out": None if held_out is None or held_out > width else round(held_out, 4),
        "views": [
            {
                "index": i if indices is None else indices[i],
                "rms": _digits(calibration.view_errors[i], 5),
                "points": _to_lists(view.image_points, lambda x: round(x, 2)),
                "residuals": _to_lists(calibration.residuals[i], lambda x: round(x, 3)),
                "rvec": [_digits(x, 8) for x in calibration.poses[i, :3]],
                "tvec": [_digits(x, 6) for x in calibration.poses[i, 3:]],
                "cut": [int(n) for n in np.flatnonzero(~calibration.used[i])],
                "reason": calibration.cut_views.get(i),
            }
            for i, view in enumerate(views)
        ],
    }


def board_sentence(figures: Mapping[str, Any] | None, length_mm: float | None = None) -> str | None:
    """Sentence on the board for its owner; None if nothing is certain.

    `figures`: as `BoardShape.figures` or a record's ``board_shape``. `length_mm`: longer extent of the
    board's corners, with which the bend is stated in millimetres.
    """
    if figures is None:
        return None
    what, sag, stretch = [], figures["sag"], figures["stretch"]
    if sag > MIN_CERTAIN_SIGMAS * figures["sag_std"]:
        bend = f"{_figure(sag * length_mm)} mm" if length_mm else f"{_percent(sag)} of its length"
        what.append(f"bent by {bend}")
    if stretch > MIN_CERTAIN_SIGMAS * figures["stretch_std"]:
        what.append(_PRINT[figures.get("stretch_kind")].format(_percent(stretch)))
    return f"Your board is {' and '.join(what)}; that was taken into account." if what else None


def _percent(share: float) -> str:
    return f"{_figure(100 * share)} %"


def _figure(value: float) -> str:
    return f"{value:.1f}" if value >= 0.1 else f"{value:.1g}"


def _board(shape: BoardShape) -> dict[str, Json]:
    figures = shape.figures()
    return {name: value if isinstance(value, str) else _digits(value) for name, value in figures.items()}


def _digits(value: float, digits: int = 3) -> float | None:
    return float(f"{float(value):.{digits}g}") if np.isfinite(value) else None


def _to_lists(values: Array, rounded: Callable[[float], float | None]) -> list[Json]:
    return [[rounded(float(x)) if np.isfinite(x) else None for x in row] for row in values]
