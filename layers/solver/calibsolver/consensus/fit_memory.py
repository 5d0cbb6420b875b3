"""Cache of fits to members' views: a new calibration repools a camera whose other members are unchanged."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from ..fitting.calibration import Calibration
from ..fitting.fit import fit
from ..view import View

MAX_FITS = 256
"""Fits remembered by a process, those used last: of 64 members under four models."""
MAX_FIT_POINTS = 4000
"""Points of a member whose fit is remembered: with so many each, all of them hold 100 MB."""


@dataclass(frozen=True)
class _Request:
    """Views of one member to which a model is to be fitted; equal where the points are."""

    digest: bytes
    img_size: tuple[int, int]
    model: str
    views: Sequence[View] = field(compare=False)


def fit_once(views: Sequence[View], img_size: tuple[int, int], model: str) -> Calibration:
    """Fit a model and the board's shape to a member's views, or recall that of the same points.

    Raises as `fit` does.
    """
    if sum(map(len, views)) > MAX_FIT_POINTS:
        return fit(views, img_size, model)
    return _fit(_Request(_digest(views), img_size, model, views))


@lru_cache(maxsize=MAX_FITS)
def _fit(request: _Request) -> Calibration:
    return fit(request.views, request.img_size, request.model)


def forget() -> None:
    """Forget all fits, as a process that has just started."""
    _fit.cache_clear()


def _digest(views: Sequence[View]) -> bytes:
    """Digest of all points, view by view."""
    digest = hashlib.sha256()
    for view in views:
        digest.update(len(view).to_bytes(8, "big") + bytes([view.flat]))
        for points in (view.object_points, view.image_points):
            digest.update(np.ascontiguousarray(points, dtype=np.float64).tobytes())
    return digest.digest()
