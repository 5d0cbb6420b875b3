"""Consistency of views: tests whether they come from one camera.

A bad view need not look bad: the parameters of another camera explain a view of that camera, and any first
view fits. So views are fitted together. If they contradict each other, the majority is believed.
"""

from collections import OrderedDict
from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from ..arrays import Array, IntArray, subsample
from ..camera import Camera
from ..errors import CalibrationError
from ..fitting.calibration import Calibration
from ..fitting.fit import MIN_SHAPE_VIEWS, fit
from ..fitting.robust_covariance import SAME_POSE_WIDTHS
from ..view import View

MAX_ERROR_RATIO = 3.0
"""Error of a consistent view / error of the others."""
MIN_ERROR_WIDTHS = 0.3 / 1280
"""Error / image width below which no ratio counts: a webcam's corners are never better."""
MIN_VIEW_INLIER_SHARE = 0.75
"""Share of inliers in a view: gross outliers are few."""
MIN_IMPROVEMENT = 1.4
"""Error with a view / error without it, from which the difference is not one of chance."""
SUSPECT_ERROR_RATIO = 1.8
"""Error of a view / error of the typical view, from which the view is tested again."""
MAX_OUTVOTED_VIEWS = 3
"""Accepted views that a larger group of later views may exclude: then the camera changed."""
CACHE_SIZE = 24
MAX_TRIAL_POINTS = 64
"""Points of a view in trials of consistency."""


class Consistency:
    """Tests of views against each other; caches its last fits. `start`: a camera that may be near."""

    def __init__(self, img_size: tuple[int, int], model: str, start: Camera | None = None) -> None:
        self.img_size = img_size
        self.model = model
        self.start = start
        self.min_error = MIN_ERROR_WIDTHS * img_size[0]
        self._fits: OrderedDict[tuple[int, ...], tuple[tuple[View, ...], Calibration | None]] = OrderedDict()
        self._thinned: dict[int, tuple[View, View]] = {}

    def fit(self, views: Sequence[View]) -> Calibration | None:
        """Fit `views` and the shape of their board; None if no camera is believable, or nothing to fit."""
        return self._fit(views, None, len(views) >= MIN_SHAPE_VIEWS)

    def fit_trial(self, views: Sequence[View], near: Calibration | None = None) -> Calibration | None:
        """Fit to MAX_TRIAL_POINTS points of each view, with the board as drawn."""
        return self._fit([self._thin(view) for view in views], near, bends=False)

    def _fit(self, views: Sequence[View], near: Calibration | None, bends: bool) -> Calibration | None:
        """Fit from `near`, or where the fit to one view less ended, or else the one to fewer points."""
        if not views:
            return None
        key = (int(bends), *(id(view) for view in views))
        if key not in self._fits:
            near = near or self._fits.get(key[:-1], ((), None))[1]
            if near is None and (bends or any(self._thin(view) is not view for view in views)):
                near = self.fit_trial(views)
            start = near.camera if near else self.start
            result = None
            with suppress(CalibrationError):
                result = fit(views, self.img_size, self.model, start=start, board_shape=bends)
            self._fits[key] = (tuple(views), result)
            if len(self._fits) > CACHE_SIZE:
                self._fits.popitem(last=False)
        return self._fits[key][1]

    def _thin(self, view: View) -> View:
        if id(view) not in self._thinned:
            self._thinned[id(view)] = view, thin(view)
        return self._thinned[id(view)][1]

    def is_consistent(self, others: Sequence[View], view: View) -> bool:
        """True if one camera explains `view` together with the `others` about as well as without it."""
        before = self.fit_trial(others)
        after = self.fit_trial([*others, view], before)
        if after is None or (len(others) in after.cut_views):
            return False
        inliers = after.used[-1]
        if inliers.mean() < MIN_VIEW_INLIER_SHARE and after.view_errors[-1] > self.min_error:
            return False
        if not others:
            return bool(after.rms_inliers <= 10 * self.min_error)
        if before is None:
            return True
        # The view adds to the error of all: its own error, and the increase of the others'.
        added = max(squared_errors(after).sum() - squared_errors(before).sum(), 0.0)
        rms = np.sqrt(added / max(int(inliers.sum()), 1))
        return bool(rms <= MAX_ERROR_RATIO * max(before.rms_inliers, self.min_error))

    def find_consistent_views(self, view: View, candidates: Sequence[View], more_than: int) -> list[View]:
        """Views that agree with `view` and each other: it first, then the newest.

        Stops when more than `more_than` can no longer be found.
        """
        consistent = [view]
        for left, other in zip(range(len(candidates), 0, -1), reversed(candidates), strict=True):
            if len(consistent) + left <= more_than:
                break
            is_new = not any(self.is_same_pose(other, one) for one in consistent)
            if is_new and self.is_consistent(consistent, other):
                consistent.append(other)
        return consistent

    def find_conflicting_view(self, views: Sequence[View], view: View) -> int | None:
        """Index of the one of `views` that conflicts with `view`, and with the rest, or None.

        Without it the rest and `view` agree, and clearly better than all of `views` agree with it.
        """
        whole = self.fit_trial(views)
        if whole is None or len(views) < 2:
            return None
        largest = whole.rms_inliers / MIN_IMPROVEMENT
        if self.min_error > largest:
            return None  # they agree so well that none of them can be wrong
        best: tuple[float, int] | None = None
        for i in range(len(views)):
            rest = [*views[:i], *views[i + 1 :]]
            without = self.fit_trial(rest, whole)
            if without is not None:
                # The points of `view` add to the squared error of the rest: here, as if they had none.
                count = sum(u.sum() for u in without.used) + len(self._thin(view))
                if np.sqrt(squared_errors(without).sum() / count) > largest:
                    continue
            if not self.is_consistent(rest, view):
                continue
            together = self.fit_trial([*rest, view])
            if together is not None and (best is None or together.rms_inliers < best[0]):
                best = together.rms_inliers, i
        return best[1] if best is not None and best[0] <= largest else None

    def find_outlier_view(self, views: Sequence[View]) -> int | None:
        """Index of an accepted view that is not consistent with the others, or None."""
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
        """True if two views show the board in one pose."""
        if np.array_equal(one.object_points, other.object_points):
            distance = np.linalg.norm(one.image_points - other.image_points, axis=1)
        else:
            i, k = common_points(one, other)
            if len(i) < 0.5 * min(len(one), len(other)):
                return False
            distance = np.linalg.norm(one.image_points[i] - other.image_points[k], axis=1)
        return bool(distance.mean() < SAME_POSE_WIDTHS * self.img_size[0])


def thin(view: View) -> View:
    """View with MAX_TRIAL_POINTS of its points, from all over it; itself if it has no more."""
    if len(view) <= MAX_TRIAL_POINTS:
        return view
    return view.subset(subsample(len(view), MAX_TRIAL_POINTS))


def common_points(one: View, other: View) -> tuple[IntArray, IntArray]:
    """Indices (m,) of common points of the board in each of two views."""
    places = [np.round(view.object_points * 1e6) + 0.0 for view in (one, other)]  # -0.0 is 0.0
    index = {place.tobytes(): n for n, place in enumerate(places[0])}
    pairs = [(index[p.tobytes()], n) for n, p in enumerate(places[1]) if p.tobytes() in index]
    shared = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    return shared[:, 0], shared[:, 1]


def squared_errors(calibration: Calibration) -> Array:
    """Sum (v,) px^2 of each view's squared residuals, over the inliers."""
    pairs = zip(calibration.residuals, calibration.used, strict=True)
    return np.array([float(np.sum(e[u] ** 2)) for e, u in pairs])
