"""All views of a calibration as padded arrays, so that one numpy call works on all of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from ..arrays import Array, IntArray, Mask
from ..view import View

Kind = TypeVar("Kind", bound=np.generic)


MIX = 0.618
"""Share of y in the number by which points are ordered: no grid has two points with the same."""


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
    scale
        (v, n) roots of the weights, of mean square 1 over all points; None: all are 1.
    """

    points: Array
    pixels: Array
    mask: Mask
    scale: Array | None = None

    @classmethod
    def of(cls, views: Sequence[View]) -> "Observations":
        """Pack `views`; at least one, none empty."""
        lengths = np.array([len(view) for view in views])
        n = int(lengths.max())
        index = np.minimum(np.arange(n), lengths[:, None] - 1)
        points = np.stack([view.object_points[i] for view, i in zip(views, index, strict=True)])
        pixels = np.stack([view.image_points[i] for view, i in zip(views, index, strict=True)])
        mask = np.arange(n) < lengths[:, None]
        return cls(
            np.ascontiguousarray(points.transpose(0, 2, 1)),
            np.ascontiguousarray(pixels.transpose(0, 2, 1)),
            mask,
            _scale(views, n),
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
        """Observations of some of the views."""
        scale = None if self.scale is None else self.scale[index]
        return Observations(self.points[index], self.pixels[index], self.mask[index], scale)

    def sort_canonically(self) -> tuple["Observations", "Order"]:
        """Same observations in an order that does not depend on the one they came in."""
        key = np.where(self.mask, self.pixels[:, 0] + MIX * self.pixels[:, 1], np.inf)
        points = np.argsort(key, axis=1, kind="stable")
        key = np.take_along_axis(key, points, axis=1)
        views = np.argsort(np.where(self.mask, key, 0.0).sum(axis=1), kind="stable")
        points, mask = points[views], self.mask[views]
        # what stands for points that are not there must not depend on the order either
        filled = np.where(mask, points, points[:, :1])[:, None]
        scale = None if self.scale is None else np.take_along_axis(self.scale[views], filled[:, 0], axis=1)
        return (
            Observations(
                np.take_along_axis(self.points[views], filled, axis=2),
                np.take_along_axis(self.pixels[views], filled, axis=2),
                mask,
                scale,
            ),
            Order(views, points),
        )


@dataclass(frozen=True, eq=False)
class Order:
    """Order of observations: view (v,) and point (v, n) at each place."""

    views: IntArray
    points: IntArray

    def back(self, values: npt.NDArray[Kind]) -> npt.NDArray[Kind]:
        """Values (v, ...) of ordered views in the order they came in."""
        found = np.empty_like(values)
        found[self.views] = values
        return found

    def points_back(self, values: npt.NDArray[Kind]) -> npt.NDArray[Kind]:
        """Values (v, n) of ordered points in the order they came in."""
        found = np.empty_like(values)
        found[self.views[:, None], self.points] = values
        return found


def _scale(views: Sequence[View], n: int) -> Array | None:
    if all(view.weights is None for view in views):
        return None
    out = np.ones((len(views), n))
    for row, view in zip(out, views, strict=True):
        if view.weights is not None:
            row[: len(view)] = np.sqrt(view.weights)
    measured = np.arange(n) < np.array([[len(view)] for view in views])
    out /= np.sqrt(np.mean(np.sort(out[measured]) ** 2))  # sorted: the same in any order of views
    return None if np.allclose(out[measured], 1, rtol=0, atol=1e-12) else out
