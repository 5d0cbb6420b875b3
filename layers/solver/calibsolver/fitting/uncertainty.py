"""Projection uncertainty: the covariance of the intrinsics, propagated to the image.

A turn of the camera frame is not an error, because users estimate the pose. So the rotation that fits best
over the whole image is projected out first (mrcal's "projection uncertainty" does the same with the poses of
the boards; here the points lie at infinity and only a rotation remains).
"""

from dataclasses import dataclass

import numpy as np

from .. import models, rotation
from ..arrays import Array, Mask
from ..camera import Camera, pixel_grid
from ..models import Model

MIN_STRETCH = 0.25
"""Radial magnification / that on the axis, below which a small change of the coefficients ends the
domain. Real corners have 0.34 at least (a fisheye lens, 93 degrees)."""
ANGLE_STEPS = 256
DIRECTIONS = 72


@dataclass(frozen=True)
class Uncertainty:
    """Predicted error of a projection, px rms and maximum, and the share of the image that has rays."""

    rms: float
    max: float
    coverage: float = 1.0


def projection_jacobian_rotation_free(
    model: Model, k: Array, img_size: tuple[int, int], grid: tuple[int, int], among: Mask | None = None
) -> Array:
    """Derivative (columns * rows, 2, p) of projection by intrinsics over a grid, best rotation removed.

    NaN outside the model's one-to-one domain, beyond `determined_half_angle`, and if not `among` the pixels.
    """
    v = model.unproject(k, pixel_grid(img_size, grid).reshape(2, -1))
    out = np.full((v.shape[1], 2, model.size), np.nan)
    with np.errstate(all="ignore"):  # at the edge of the domain a derivative may be unbounded
        _, by_k, by_p = model.jacobian(k, v)
    seen = np.isfinite(by_k).all(axis=(0, 1)) & np.isfinite(by_p).all(axis=(0, 1))
    angle = np.arctan2(np.hypot(v[0], v[1]), v[2])
    seen &= angle < determined_half_angle(model, k, float(angle[seen].max(initial=0.0)))
    seen &= True if among is None else among
    if not seen.any():
        return out
    v = v[:, seen]
    d = by_k[:, :, seen].transpose(2, 1, 0)  # (n, 2, p)
    b = by_p[:, :, seen].transpose(2, 1, 0)  # (n, 2, 3)
    turn = np.cross(v.T[:, None, :], b)  # b . (w x v) = w . (v x b)
    flat, flat_d = turn.reshape(-1, 3), d.reshape(-1, model.size)
    removed = np.linalg.lstsq(flat, flat_d, rcond=None)[0]
    out[seen] = (flat_d - flat @ removed).reshape(d.shape)
    return out


def determined_half_angle(model: Model, k: Array, largest: float) -> float:
    """Angle from the axis, up to the `largest`, at which the radial magnification falls below MIN_STRETCH.

    Infinite if it does not. The domain ends there in some fits of a lens and not in others: the error would
    jump.
    """
    angle = np.linspace(0, largest, ANGLE_STEPS)
    ray = np.stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)])
    with np.errstate(all="ignore"):
        _, _, by_p = model.jacobian(k, ray)
    along = np.stack([np.cos(angle), np.zeros_like(angle), -np.sin(angle)])
    stretch = np.hypot(*np.einsum("ian,in->an", by_p, along))
    low = stretch < MIN_STRETCH * stretch[0]
    return float(angle[np.argmax(low)]) if low.any() else np.inf


def image_error_metric(d: Array) -> Array:
    """Matrix W (p, p) such that trace(covariance @ W) is the mean square projection error, px^2.

    `d` is (n, 2, p) as from `projection_jacobian_rotation_free`.
    """
    seen = d[np.isfinite(d[:, 0, 0])]
    flat = seen.reshape(-1, d.shape[2])
    return flat.T @ flat / max(len(seen), 1)


def variance(d: Array, covariance: Array) -> Array:
    """Predicted square error (n,) px^2, both axes added, of `d` (n, 2, p) under a covariance (p, p)."""
    v: Array = ((d @ covariance) * d).sum(axis=(1, 2))
    return v


def square_errors(
    camera: Camera, covariance: Array, grid: tuple[int, int], among: Mask | None = None
) -> Array:
    """Predicted square errors (columns * rows,) px^2 of a camera's projections over a grid.

    NaN as `projection_jacobian_rotation_free`.
    """
    model, k = models.get(camera.model), camera.intrinsics
    d = projection_jacobian_rotation_free(model, k, camera.img_size, grid, among)
    with np.errstate(invalid="ignore"):
        return np.maximum(variance(d, covariance), 0)


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


@dataclass(frozen=True, eq=False)
class Rivals:
    """Cameras of other models that explain the views as well, and the hull of the corners.

    In the hull they draw the same picture. Outside of it only the form of the model decides. The covariance
    takes the model for granted, so there the distance of the rivals is part of the error.
    """

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
                own = np.nan_to_num(square_errors(rival.camera, rival.covariance, grid), nan=0.0)
                square = np.sum(away**2, axis=1) + own
                largest = np.fmax(largest, np.where(inside, 0.0, square))
        return largest
