"""Rivals of a calibration: cameras of other models that explain its views as well.

They draw the same picture where the board has been. Elsewhere only the form of the model decides. The
covariance takes the model for granted, so there the distance of the rivals is part of the error.
"""

from dataclasses import dataclass

import numpy as np

from .. import models, rotation
from ..arrays import Array, Mask
from ..camera import Camera, pixel_grid
from .uncertainty import square_errors

DIRECTIONS = 72


@dataclass(frozen=True, eq=False)
class Hull:
    """Convex hull of corners: (DIRECTIONS,) px, their largest coordinate along each direction."""

    farthest: Array

    @classmethod
    def of(cls, points: Array) -> "Hull":
        """Hull of points (m, 2), px."""
        return cls((points @ _directions()).max(axis=0, initial=-np.inf))

    def contains(self, pixels: Array) -> Mask:
        """True (n,) for pixels (n, 2) in the hull."""
        return np.asarray((pixels @ _directions() <= self.farthest).all(axis=1))


def _directions() -> Array:
    angle = np.linspace(0, 2 * np.pi, DIRECTIONS, endpoint=False)
    return np.stack([np.cos(angle), np.sin(angle)])


@dataclass(frozen=True, eq=False)
class Rival:
    """Camera of another model, and the covariance (p, p) of its intrinsics."""

    camera: Camera
    covariance: Array

    def variance(self, grid: tuple[int, int]) -> Array:
        """Variance (rows * columns,) px^2 of its own projections, 0 where it has none."""
        return np.nan_to_num(square_errors(self.camera, self.covariance, grid), nan=0.0)


@dataclass(frozen=True, eq=False)
class Rivals:
    """Cameras that explain the views as well, and the hull of the corners, outside of which they count."""

    rivals: tuple[Rival, ...]
    hull: Hull

    def square_error(self, camera: Camera, grid: tuple[int, int]) -> Array:
        """Largest square error (rows * columns,) px^2 of a camera, if a rival is right, at cells of a grid.

        The square distance from the rival's projections after the turn that makes both alike in the hull
        (Kabsch 1976), and their variance. 0 in the hull, and where rivals have no picture.
        """
        q = pixel_grid(camera.img_size, grid).reshape(2, -1)
        inside = self.hull.contains(q.T)
        largest = np.zeros(q.shape[1])
        with np.errstate(all="ignore"):  # at the edge of a domain numbers may overflow
            rays = models.get(camera.model).unproject(camera.intrinsics, q)
            for rival in self.rivals:
                theirs = models.get(rival.camera.model).unproject(rival.camera.intrinsics, q)
                shared = inside & np.isfinite(rays[0]) & np.isfinite(theirs[0])
                if not shared.any():
                    continue
                turn = rotation.nearest(theirs[:, shared] @ rays[:, shared].T)
                away = rival.camera.project((turn @ rays).T) - q.T
                square = np.sum(away**2, axis=1) + rival.variance(grid)
                largest = np.fmax(largest, np.where(inside, 0.0, square))
        return largest
