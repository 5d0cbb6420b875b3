"""Camera model: the interface of a projection with its derivatives, its prior and its initial intrinsics.

Coordinates come first, so that every formula works on whole planes of points: points are (3, ...), pixels (2,
...), derivatives (variable, image axis, ...). Intrinsics are one vector `k`: fx fy cx cy, then the distortion
coefficients in the order of the model's definition.
"""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..arrays import Array, Mask


@dataclass(frozen=True)
class Coefficient:
    """Gaussian prior of one distortion coefficient.

    Attributes
    ----------
    sigma
        Standard deviation on a narrow lens.
    order
        Power of the squared image radius (in focal lengths) that it multiplies; 0: the belief does not depend
        on it.
    edge
        Standard deviation of its effect at the corner of the image / distance of the corner from the centre.
    sign
        Sign of its effect: -1 in a denominator.
    mean
        Expected value; 0 if it bends the image.
    """

    sigma: float
    order: int = 0
    edge: float = 1.0
    sign: int = 1
    mean: float = 0.0


@dataclass(frozen=True)
class Prior:
    """Prior of a camera's intrinsics: independent Gaussians.

    Rounded from 7,700 published calibrations (the lens profiles of Gyroflow, CC0): half of the focal lengths
    lie within 0.55 to 1.3 image widths, 9 of 10 principal points within 3 % of the centre.

    Attributes
    ----------
    focal, focal_sigma
        Focal length / image width, and the standard deviation of its logarithm.
    aspect_sigma
        Standard deviation of log(fx / fy): pixels are nearly square.
    center_sigma
        Standard deviation of the principal point from the image centre / image width.
    """

    focal: float
    focal_sigma: float
    distortion: tuple[Coefficient, ...]
    aspect_sigma: float = 0.01
    center_sigma: float = 0.03


class Model(ABC):
    """A central projection: a distortion of the ray's direction followed by fx, fy, cx, cy (no skew)."""

    name: str
    coefficients: tuple[str, ...]
    prior: Prior
    start_focals: tuple[float, ...]
    """Focal lengths / image width from which a fit is started."""
    start_families: int = 1
    """Families of initial intrinsics that may lead to different optima: the best of each is followed."""
    is_perspective: bool = False
    """True if it is a pinhole without distortion: straight lines stay straight."""
    max_angle: float = math.pi
    """Angle from the axis, radians, up to which its coordinates distinguish directions."""

    @property
    def size(self) -> int:
        """Number of intrinsics, p."""
        return 4 + len(self.coefficients)

    @abstractmethod
    def distort(self, d: Array, p: Array) -> Array:
        """Project points (3, ...), camera frame, any length, to the plane of unit focal length, (2, ...)."""

    @abstractmethod
    def distort_jacobian(self, d: Array, p: Array) -> tuple[Array, Array, Array]:
        """`distort` and its derivatives by the m coefficients (m, 2, ...) and by the point (3, 2, ...)."""

    @abstractmethod
    def undistort(self, d: Array, u: Array) -> Array:
        """Unit rays (3, ...) that project to (2, ...); NaN where no ray of the valid domain does."""

    @abstractmethod
    def domain_half_angle(self, d: Array) -> float:
        """Largest angle from the axis, radians, up to which the projection is one-to-one."""

    def valid(self, d: Array, p: Array) -> Mask:
        """True if points (3, ...) lie where the projection is one-to-one."""
        inside: Mask = p[2] > np.cos(self.domain_half_angle(d)) * np.sqrt(
            p[0] * p[0] + p[1] * p[1] + p[2] * p[2]
        )
        return inside

    def magnification(self, d: Array) -> tuple[float, Array]:
        """Image radius / angle at the axis for unit focal lengths, and its derivatives by d (m,)."""
        return 1.0, np.zeros(len(d))

    def focal(self, k: Array) -> Array:
        """Focal lengths (2,) along x and y at k (p,), px per radian at the axis.

        `k[:2]` if it magnifies by 1.
        """
        return k[:2] * self.magnification(k[4:])[0]

    def radial_derivative(self, d: Array, s: Array) -> tuple[Array, Array, Array] | None:  # noqa: ARG002
        """Radial stretch, d(distorted)/d(undistorted radius), at squared radii s (n,).

        And its derivatives by d (n, m) and by s (n,). None if the first order of `Prior` says it.
        """
        return None

    def start(self, focal: float, img_size: tuple[int, int]) -> Array:
        """Intrinsics (p,) without distortion, principal point in the image centre; focal in px."""
        k = np.zeros(self.size)
        k[:4] = focal, focal, (img_size[0] - 1) / 2, (img_size[1] - 1) / 2
        return k

    def initial_intrinsics(self, img_size: tuple[int, int]) -> list[Array]:
        """Intrinsics (p,) from which a fit is started; family after family, of each the same number."""
        return [self.start(f * img_size[0], img_size) for f in self.start_focals]

    def project(self, k: Array, p: Array) -> Array:
        """Pixels (2, ...) of points (3, ...) in the camera frame; meaningless outside `valid`."""
        u = self.distort(k[4:], p)
        return np.array([k[0] * u[0] + k[2], k[1] * u[1] + k[3]])

    def jacobian(self, k: Array, p: Array) -> tuple[Array, Array, Array]:
        """Pixels (2, ...) and their derivatives by k (p, 2, ...) and by the point (3, 2, ...)."""
        by_k, by_p = np.empty((self.size, 2, *p.shape[1:])), np.empty((3, 2, *p.shape[1:]))
        return self.fill_jacobian(k, p, by_k, by_p), by_k, by_p

    def fill_jacobian(self, k: Array, p: Array, by_k: Array, by_p: Array) -> Array:
        """Pixels (2, ...); their derivatives by k (p, 2, ...) and by the point (3, 2, ...) are filled in."""
        u, by_d, by_point = self.distort_jacobian(k[4:], p)
        shape = (2,) + (1,) * (u.ndim - 1)
        f, c = k[:2].reshape(shape), k[2:4].reshape(shape)
        by_k[:4] = 0
        by_k[0, 0], by_k[1, 1] = u
        by_k[2, 0] = by_k[3, 1] = 1
        np.multiply(by_d, f, out=by_k[4:])
        np.multiply(by_point, f, out=by_p)
        return f * u + c

    def unproject(self, k: Array, q: Array) -> Array:
        """Unit rays (3, ...) in the camera frame of pixels (2, ...); NaN outside the valid domain."""
        return self.undistort(k[4:], np.stack([(q[0] - k[2]) / k[0], (q[1] - k[3]) / k[1]]))


@lru_cache(maxsize=64)
def first_root(coefficients: tuple[float, ...], limit: float) -> float:
    """Smallest root in (0, limit) of 1 + c0 x + c1 x^2 + ..., or `limit`."""
    polynomial = np.array([*coefficients[::-1], 1.0])
    if not np.isfinite(polynomial).all():
        return 0.0
    roots = np.roots(polynomial)
    real = roots.real[(np.abs(roots.imag) <= 1e-9 * np.abs(roots)) & (roots.real > 0)]
    return float(min(real.min(initial=limit), limit))
