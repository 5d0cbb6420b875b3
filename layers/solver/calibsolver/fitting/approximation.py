"""Approximate fit of one camera: robust, and near enough to the optimum to start a joint fit."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from .. import models
from ..arrays import Array, frozen
from ..camera import Camera
from ..view import View
from . import outliers, plausibility, validation
from .levenberg_marquardt import Problem, robust_sigma
from .multistart import MultiStart, refit_without_gross_outliers
from .validation import check, degenerate_views, pack


@dataclass(frozen=True, eq=False)
class Approximation:
    """Camera near the optimum, poses (v, 6) rvec|tvec, NaN of degenerate views, and noise, px per coordinate.

    `cut_views`: reasons why views (by number) are left out, ``degenerate``, ``mirrored`` or ``outlier``.
    """

    camera: Camera
    poses: Array
    noise: float
    cut_views: Mapping[int, str]


def approximate(
    views: Sequence[View],
    img_size: tuple[int, int],
    model: str = "rectilinear",
    *,
    start: Camera | None = None,
) -> Approximation:
    """Fit a camera model to near the optimum; arguments and errors are those of `fit`, robust."""
    packed = pack(views, img_size)
    degenerate, mirrored = degenerate_views(packed), validation.mirrored_views(packed)
    if degenerate.all():
        check(views, img_size)  # raises
    usable = np.flatnonzero(~degenerate)
    obs, order = packed.subset(usable).sort_canonically()
    problem = Problem(models.get(model), obs, img_size)
    mask = obs.mask & ~mirrored[usable][order.views][:, None]
    with np.errstate(all="ignore"):  # far from the solution numbers may overflow; every step is tested
        state = refit_without_gross_outliers(problem, MultiStart(problem, mask, start).run(), mask)
        good = outliers.inlier_mask(state, mask, mask, img_size[0], outliers.GROSS_OUTLIER_SIGMAS)
        plausibility.check_result(problem, state, good, robust=True)
    poses = np.full((len(views), 6), np.nan)
    poses[usable] = order.back(state.poses.vectors())
    left = order.back(np.asarray(good.any(axis=1)))
    reasons = {int(i): "degenerate" for i in np.flatnonzero(degenerate)}
    reasons |= {int(i): "mirrored" if mirrored[i] else "outlier" for i in usable[~left]}
    return Approximation(
        Camera.from_intrinsics(model, state.k, img_size), frozen(poses), robust_sigma(state, good), reasons
    )
