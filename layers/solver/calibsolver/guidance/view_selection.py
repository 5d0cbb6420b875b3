"""Selection of views that exist already, by the criterion of the guidance."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..arrays import Array, symmetric_inverse
from ..errors import CalibrationError
from ..fitting import prior
from ..fitting.fit import fit
from ..fitting.observations import Observations
from ..fitting.resection import resect
from ..view import View
from .posterior import IntrinsicsPosterior


def select_views(
    views: Sequence[View],
    img_size: tuple[int, int],
    model: str = "rectilinear",
    count: int = 6,
    systematic: float = 1.0,
) -> list[int]:
    """Select the views that reduce the predicted projection error most, one after the other.

    Each is chosen by the estimate from those before it, as a guided capture chooses a pose; the first by the
    prior alone. Returns their indices, at most `count`, in the order in which they were chosen. `systematic`
    is the size of the systematic errors to expect in a view / the usual one (`systematic_errors`).
    """
    obs = Observations.of(views)
    chosen: list[int] = []
    calibration = None
    while len(chosen) < min(count, len(views)):
        posterior = replace(IntrinsicsPosterior.of(model, img_size, calibration), systematic=systematic)
        information = view_information(posterior, obs)
        total = prior.information(posterior.model, posterior.k, img_size) + information[chosen].sum(axis=0)
        left = [i for i in range(len(views)) if i not in chosen]
        after = symmetric_inverse(total + information[left])
        error = np.einsum("vij,ij->v", after, posterior.error_metric)
        chosen.append(left[int(np.nanargmin(error))])
        try:
            calibration = fit([views[i] for i in chosen], img_size, model, board_shape=False)
        except CalibrationError:
            calibration = None
    return chosen


def view_information(posterior: IntrinsicsPosterior, obs: Observations) -> Array:
    """Fisher information (v, p, p) of views under the posterior's camera; 0 of one that it cannot pose."""
    poses, square = resect(posterior.model, posterior.k, obs)
    with np.errstate(all="ignore"):
        s = posterior.view_information(obs, poses)
    posed = np.isfinite(square) & np.isfinite(s).all(axis=(1, 2))
    return np.where(posed[:, None, None], s, 0.0) / posterior.noise**2
