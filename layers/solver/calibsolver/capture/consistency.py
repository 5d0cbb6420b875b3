"""Which of the views are of one camera.

A bad view need not look bad: another camera's is explained by another camera's numbers, and whichever view
came first is right by itself. So views are tried together, and where they contradict each other the larger
part is believed.
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

OUTLIER = 3.0
"""Times the others' error from which a view does not belong to them."""
FLOOR = 0.3 / 1280
"""px of error / image width below which corners are as good as a webcam's ever are: no ratio counts there."""
KEPT = 0.75
"""Share of a view's points that must be good: wild points are a few, not a good part of the view."""
CLEARLY = 1.4
"""Times the error without a view from which the error with it is another, not the same by chance."""
SUSPICIOUS = 1.8
"""Times the typical view's error from which a view is looked at again."""
PATIENCE = 3
"""Views that are outvoted by one more that agree; then it was the camera that changed."""
SAME = 0.02
"""Mean distance of corners / image width below which two views are one pose, and one witness."""
REMEMBERED = 24
"""Fits kept, of those asked for last."""


class Consistency:
    """Tries views together; remembers its last fits, so that nothing is fitted twice within a request.

    Parameters
    ----------
    img_size, model
        What is fitted; width and height in px.
    start
        A camera that may be near, where fits start first.
    """

    def __init__(self, img_size: tuple[int, int], model: str, start: Camera | None = None) -> None:
        self.img_size = img_size
        self.model = model
        self.start = start
        self.floor = FLOOR * img_size[0]
        self._fits: OrderedDict[tuple[int, ...], tuple[tuple[View, ...], Calibration | None]] = OrderedDict()

    def fit(self, views: Sequence[View]) -> Calibration | None:
        """Fit `views`; None where there is no believable camera, or nothing to fit."""
        if not views:
            return None
        key = tuple(id(view) for view in views)
        if key not in self._fits:
            before = self._fits.get(key[:-1], ((), None))[1]
            near = before.camera if before else self.start
            try:
                found: Calibration | None = fit(views, self.img_size, self.model, start=near)
            except CalibrationError:
                found = None
            self._fits[key] = (tuple(views), found)
            if len(self._fits) > REMEMBERED:
                self._fits.popitem(last=False)
        return self._fits[key][1]

    def belongs(self, others: Sequence[View], view: View) -> bool:
        """Whether one camera explains `view` together with the `others` about as well as without it."""
        after = self.fit([*others, view])
        if after is None or (len(others) in after.cut_views):
            return False
        last = after.used[-1]
        if last.mean() < KEPT and after.view_errors[-1] > self.floor:
            return False
        if not others:
            return bool(level(after) <= 10 * self.floor)
        before = self.fit(others)
        if before is None:
            return True
        # What the view adds to the error of all: its own, and what it does to the others'.
        added = max(squares(after).sum() - squares(before).sum(), 0.0) / max(int(last.sum()), 1)
        return bool(np.sqrt(added) <= OUTLIER * max(level(before), self.floor))

    def group(self, seed: View, witnesses: Sequence[View]) -> list[View]:
        """Return the views that agree with `seed` and each other: it first, then the newest first."""
        agreed = [seed]
        for view in reversed(witnesses):
            if not any(self.alike(view, other) for other in agreed) and self.belongs(agreed, view):
                agreed.append(view)
        return agreed

    def culprit(self, views: Sequence[View], view: View) -> int | None:
        """Return which of `views` is wrong where `view` does not belong to all of them, if one is.

        Without it the rest and `view` agree, and clearly better than all of `views` agree with it.
        """
        whole = self.fit(views)
        if whole is None or len(views) < 2:
            return None
        found: tuple[float, int] | None = None
        for i in range(len(views)):
            rest = [*views[:i], *views[i + 1 :]]
            if not self.belongs(rest, view):
                continue
            together = self.fit([*rest, view])
            if together is not None and (found is None or level(together) < found[0]):
                found = level(together), i
        if found is None or max(found[0], self.floor) * CLEARLY > level(whole):
            return None
        return found[1]

    def misfit(self, views: Sequence[View]) -> int | None:
        """Return which of accepted `views` turned out not to belong to the others, if one does."""
        whole = self.fit(views)
        if whole is None or len(views) < 3:
            return None
        if whole.cut_views:
            return int(min(whole.cut_views))
        errors = np.sqrt(squares(whole) / np.maximum([u.sum() for u in whole.used], 1))
        typical = max(float(np.median(errors)), self.floor)
        for i in np.argsort(errors)[::-1]:
            if errors[i] < SUSPICIOUS * typical:
                break
            if not self.belongs([*views[:i], *views[i + 1 :]], views[i]):
                return int(i)
        return None

    def alike(self, one: View, other: View) -> bool:
        """Whether two views are of one pose."""
        if one.object_points.shape == other.object_points.shape and np.array_equal(
            one.object_points, other.object_points
        ):
            off = np.linalg.norm(one.image_points - other.image_points, axis=1)
        else:
            near = np.linalg.norm(one.object_points[:, None] - other.object_points[None], axis=2) < 1e-6
            i, k = np.nonzero(near)
            if len(i) < 0.5 * min(len(one), len(other)):
                return False
            off = np.linalg.norm(one.image_points[i] - other.image_points[k], axis=1)
        return bool(off.mean() < SAME * self.img_size[0])


def squares(calibration: Calibration) -> Array:
    """Sum (v,) px^2 of each view's squared residuals, over the points that were not cut."""
    pairs = zip(calibration.residuals, calibration.used, strict=True)
    return np.array([float(np.sum(e[u] ** 2)) for e, u in pairs])


def level(calibration: Calibration) -> float:
    """Root mean square residual, px, over the points that were not cut."""
    return float(np.sqrt(squares(calibration).sum() / max(sum(u.sum() for u in calibration.used), 1)))
