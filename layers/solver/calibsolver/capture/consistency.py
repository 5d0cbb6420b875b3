"""Consistency of views: tests whether they come from one camera.

A bad view need not look bad: a view of another camera is explained by the parameters of that camera, and
whichever view came first fits by itself. So views are fitted together, and where they contradict each other
the majority is believed.
"""

from collections import OrderedDict
from collections.abc import Sequence

import numpy as np

from ..arrays import Array
from ..camera import Camera
from ..errors import CalibrationError
from ..fitting.calibration import Calibration
from ..fitting.fit import fit
from ..view import View

MAX_ERROR_RATIO = 3.0
"""Error of a consistent view / error of the others, at most."""
MIN_ERROR_WIDTHS = 0.3 / 1280
"""px of error / image width below which no ratio counts: a webcam's corners are never better."""
MIN_VIEW_INLIER_SHARE = 0.75
"""Share of a view's points that must be inliers: gross outliers are few, not a large part of a view."""
MIN_IMPROVEMENT = 1.4
"""Error with a view / error without it, from which the difference is not one of chance."""
SUSPECT_ERROR_RATIO = 1.8
"""Error of a view / error of the typical view, from which the view is tested again."""
MAX_OUTVOTED_VIEWS = 3
"""Accepted views that a larger group of later views may exclude: then it was the camera that changed."""
SAME_POSE_WIDTHS = 0.02
"""Mean distance of corners / image width below which two views show one pose, and count as one."""
CACHE_SIZE = 24
"""Fits that are cached: those used last."""


class Consistency:
    """Tests of views against each other; caches its last fits, so nothing is fitted twice in a request.

    Parameters
    ----------
    img_size, model
        Width and height, px, and name of the model that is fitted.
    start
        A camera that may be near, where fits start first.
    """

    def __init__(self, img_size: tuple[int, int], model: str, start: Camera | None = None) -> None:
        self.img_size = img_size
        self.model = model
        self.start = start
        self.min_error = MIN_ERROR_WIDTHS * img_size[0]
        self._fits: OrderedDict[tuple[int, ...], tuple[tuple[View, ...], Calibration | None]] = OrderedDict()

    def fit(self, views: Sequence[View]) -> Calibration | None:
        """Fit `views`; None where there is no believable camera, or nothing to fit."""
        if not views:
            return None
        key = tuple(id(view) for view in views)
        if key not in self._fits:
            before = self._fits.get(key[:-1], ((), None))[1]
            start = before.camera if before else self.start
            try:
                found: Calibration | None = fit(views, self.img_size, self.model, start=start)
            except CalibrationError:
                found = None
            self._fits[key] = (tuple(views), found)
            if len(self._fits) > CACHE_SIZE:
                self._fits.popitem(last=False)
        return self._fits[key][1]

    def is_consistent(self, others: Sequence[View], view: View) -> bool:
        """Whether one camera explains `view` together with the `others` about as well as without it."""
        after = self.fit([*others, view])
        if after is None or (len(others) in after.cut_views):
            return False
        inliers = after.used[-1]
        if inliers.mean() < MIN_VIEW_INLIER_SHARE and after.view_errors[-1] > self.min_error:
            return False
        if not others:
            return bool(inlier_rms(after) <= 10 * self.min_error)
        before = self.fit(others)
        if before is None:
            return True
        # The view adds to the error of all: its own error, and the increase of the others'.
        added = max(squared_errors(after).sum() - squared_errors(before).sum(), 0.0)
        rms = np.sqrt(added / max(int(inliers.sum()), 1))
        return bool(rms <= MAX_ERROR_RATIO * max(inlier_rms(before), self.min_error))

    def find_consistent_views(self, view: View, candidates: Sequence[View]) -> list[View]:
        """Collect the views that agree with `view` and each other: it first, then the newest first."""
        consistent = [view]
        for other in reversed(candidates):
            if not any(self.is_same_pose(other, one) for one in consistent) and self.is_consistent(
                consistent, other
            ):
                consistent.append(other)
        return consistent

    def find_conflicting_view(self, views: Sequence[View], view: View) -> int | None:
        """Find the one of `views` that conflicts with `view`, and with the rest: its index, or None.

        Without it the rest and `view` agree, and clearly better than all of `views` agree with it.
        """
        whole = self.fit(views)
        if whole is None or len(views) < 2:
            return None
        best: tuple[float, int] | None = None
        for i in range(len(views)):
            rest = [*views[:i], *views[i + 1 :]]
            if not self.is_consistent(rest, view):
                continue
            together = self.fit([*rest, view])
            if together is not None and (best is None or inlier_rms(together) < best[0]):
                best = inlier_rms(together), i
        if best is None or max(best[0], self.min_error) * MIN_IMPROVEMENT > inlier_rms(whole):
            return None
        return best[1]

    def find_outlier_view(self, views: Sequence[View]) -> int | None:
        """Find an accepted view that is not consistent with the others: its index, or None."""
        whole = self.fit(views)
        if whole is None or len(views) < 3:
            return None
        if whole.cut_views:
            return int(min(whole.cut_views))
        errors = np.sqrt(squared_errors(whole) / np.maximum([u.sum() for u in whole.used], 1))
        typical = max(float(np.median(errors)), self.min_error)
        for i in np.argsort(errors)[::-1]:
            if errors[i] < SUSPECT_ERROR_RATIO * typical:
                break
            if not self.is_consistent([*views[:i], *views[i + 1 :]], views[i]):
                return int(i)
        return None

    def is_same_pose(self, one: View, other: View) -> bool:
        """Whether two views show the board in one pose."""
        if one.object_points.shape == other.object_points.shape and np.array_equal(
            one.object_points, other.object_points
        ):
            distance = np.linalg.norm(one.image_points - other.image_points, axis=1)
        else:
            same = np.linalg.norm(one.object_points[:, None] - other.object_points[None], axis=2) < 1e-6
            i, k = np.nonzero(same)
            if len(i) < 0.5 * min(len(one), len(other)):
                return False
            distance = np.linalg.norm(one.image_points[i] - other.image_points[k], axis=1)
        return bool(distance.mean() < SAME_POSE_WIDTHS * self.img_size[0])


def squared_errors(calibration: Calibration) -> Array:
    """Sum (v,) px^2 of each view's squared residuals, over the inliers."""
    pairs = zip(calibration.residuals, calibration.used, strict=True)
    return np.array([float(np.sum(e[u] ** 2)) for e, u in pairs])


def inlier_rms(calibration: Calibration) -> float:
    """Root mean square residual, px, over the inliers of all views."""
    return float(np.sqrt(squared_errors(calibration).sum() / max(sum(u.sum() for u in calibration.used), 1)))
