"""Fits that several tests need: made once in a process."""

from collections.abc import Sequence

import numpy as np

from calibsolver import Calibration, Camera, View, fit
from calibsolver.fitting.constraint import Fix

_fits: dict[object, Calibration] = {}


def fit_once(
    views: Sequence[View],
    img_size: tuple[int, int],
    model: str = "rectilinear",
    robust: bool = True,
    *,
    start: Camera | None = None,
    fix: Fix = (),
    board_shape: bool = True,
) -> Calibration:
    """Return the result of `fit`, computed once for the same arguments."""
    key = (
        *(_content(view) for view in views),
        (img_size, model, robust, board_shape, repr(fix)),
        start and (start.model, start.img_size, start.intrinsics.tobytes()),
    )
    if key not in _fits:
        _fits[key] = fit(views, img_size, model, robust, start=start, fix=fix, board_shape=board_shape)
    return _fits[key]


def _content(view: View) -> tuple[object, ...]:
    arrays = (view.object_points, view.image_points, view.weights)
    return (view.flat, *(each is None or np.asarray(each).tobytes() for each in arrays))
