"""All views of a calibration as padded arrays, so that one numpy call works on all of them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .arrays import Array, IntArray, Mask
from .view import View


@dataclass(frozen=True, eq=False)
class Observations:
    """Views padded to the longest.

    Attributes
    ----------
    points
        (v, 3, n) board frame. Padding repeats the view's first point, with weight 0.
    pixels
        (v, 2, n) px.
    mask
        (v, n) true where a point was measured.
    """

    points: Array
    pixels: Array
    mask: Mask

    @classmethod
    def of(cls, views: Sequence[View]) -> "Observations":
        """Pack `views`; at least one, none empty."""
        lengths = np.array([len(view) for view in views])
        n = int(lengths.max())
        if (lengths == n).all():
            points = np.ascontiguousarray(np.stack([view.object_points.T for view in views]))
            pixels = np.ascontiguousarray(np.stack([view.image_points.T for view in views]))
            return cls(points, pixels, np.ones((len(views), n), dtype=bool))
        index = np.minimum(np.arange(n), lengths[:, None] - 1)
        points = np.stack([view.object_points[i] for view, i in zip(views, index, strict=True)])
        pixels = np.stack([view.image_points[i] for view, i in zip(views, index, strict=True)])
        mask = np.arange(n) < lengths[:, None]
        return cls(
            np.ascontiguousarray(points.transpose(0, 2, 1)),
            np.ascontiguousarray(pixels.transpose(0, 2, 1)),
            mask,
        )

    @property
    def view_count(self) -> int:
        """Number of views."""
        return len(self.points)

    @property
    def count(self) -> int:
        """Number of measured points."""
        return int(self.mask.sum())

    def subset(self, index: IntArray) -> "Observations":
        """Return the observations of some of the views."""
        return Observations(self.points[index], self.pixels[index], self.mask[index])
