"""Cache of fits to members' views, for cameras whose other members are unchanged."""

import hashlib
from collections import OrderedDict
from collections.abc import Sequence
from threading import Lock

import numpy as np

from ..fitting.calibration import Calibration
from ..fitting.fit import fit
from ..view import View

MAX_POINTS = 50_000
"""Points of all fits in the cache, which drops those used longest ago: 3 MB; 64 members of 12 views."""

_fits: OrderedDict[tuple[bytes, tuple[int, int], str], Calibration] = OrderedDict()
_lock = Lock()


def fit_once(views: Sequence[View], img_size: tuple[int, int], model: str) -> Calibration:
    """Fit a model and the board's shape, or recall that of the same points; raises as `fit` does."""
    key = _digest(views), img_size, model
    with _lock:
        if key in _fits:
            _fits.move_to_end(key)
            return _fits[key]
    calibration = fit(views, img_size, model)
    with _lock:
        _fits[key] = calibration
        while cached_points() > MAX_POINTS:
            _fits.popitem(last=False)
    return calibration


def cached_points() -> int:
    """Number of points of all fits in the cache."""
    return sum(len(residuals) for one in _fits.values() for residuals in one.residuals)


def forget() -> None:
    """Forget all fits."""
    with _lock:
        _fits.clear()


def _digest(views: Sequence[View]) -> bytes:
    digest = hashlib.sha256()
    for view in views:
        digest.update(len(view).to_bytes(8, "big") + bytes([view.flat]))
        weights = () if view.weights is None else view.weights
        for values in (view.object_points, view.image_points, weights):
            digest.update(np.ascontiguousarray(values, dtype=np.float64).tobytes())
    return digest.digest()
